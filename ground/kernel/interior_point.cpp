#include "interior_point.hpp"

#include <algorithm>
#include <cmath>

#include "pack.hpp"
#include "skyline.hpp"

namespace halfroll::planner {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kEnds = kOrder * kAxes;  // tau-derivatives of a piece, axis by axis
constexpr int kTime = kEnds;           // place of the log of its duration
constexpr int kLocal = 44;             // both, padded to full packs
using LocalVector = Eigen::Matrix<double, kLocal, 1>;
using LocalMatrix = Eigen::Matrix<double, kLocal, kLocal>;

constexpr double kShiftSmall = 1e-3;      // mu is not reduced while shifts are larger
constexpr double kDecrement = 10.0;       // mu is reduced once the Newton decrement is below this times mu
constexpr double kNegligible = 3e-5;      // or below this share of the total time
constexpr double kLongestTimeStep = 0.5;  // of a log duration
constexpr double kBoundary = 0.01;        // share of a margin that a step must leave
constexpr int kCuts = 7, kRetries = 12;
constexpr double kCut = 0.6;
constexpr double kLong = 0.4;  // a step at least this long may end a stage of mu

/// All that is known of a piece at one point.
struct PieceState {
  MatrixXd values;  // (samples, rows)
  MatrixXd slack;   // (samples, bounds) g + e
};

struct Trial {
  Point point;
  std::vector<double> durations;
  std::vector<PieceState> pieces;
  double merit = 0.0;
};

class InteriorPoint {
 public:
  InteriorPoint(const Problem& problem, const Constraints& constraints, const Tightening& tightening,
                const SolverSettings& settings)
      : problem_(problem),
        constraints_(constraints),
        tightening_(tightening),
        settings_(settings),
        table_(settings.samples),
        unknowns_(problem),
        hessian_(unknowns_.envelope()),
        bounds_(static_cast<int>(constraints.bounds().size())) {
    for (int k = 0; k < problem.pieces(); ++k) {
      for (int b = 0; b < bounds_; ++b) bound_.push_back(constraints.on_piece(b, problem.speed_max[k]));
    }
  }

  Solution solve(const Progress& progress) {
    Solution best;
    best.trajectory = problem_.start;
    mu_ = settings_.barrier_start;
    if (!begin()) return best;
    double fastest = std::numeric_limits<double>::infinity();
    for (best.iterations = 0; best.iterations < settings_.iterations; ++best.iterations) {
      const double least = least_margin();
      const double total = sum(now_.durations);
      if (least >= 0.0 && total < fastest) {
        fastest = total;
        best_point_ = now_.point;
        best.feasible = true;
      }
      if (progress && !progress(fastest)) {
        best.interrupted = true;
        break;
      }
      assemble();
      if (!step()) {
        mu_ *= 0.3;
        if (++stuck_ > 3) break;
        continue;
      }
      if (decrement_ < std::max(kDecrement * mu_ * std::max(1.0, problem_.pieces() / 100.0),
                                kNegligible * sum(now_.durations)) &&
          length_ >= kLong && largest_shift_ < kShiftSmall) {
        if (mu_ <= settings_.barrier_end && largest_shift_ == 0.0) break;
        mu_ = std::max(mu_ * settings_.barrier_factor, settings_.barrier_end);
      }
    }
    if (least_margin() >= 0.0 && sum(now_.durations) < fastest) {
      best_point_ = now_.point;
      best.feasible = true;
    }
    best.trajectory = unknowns_.trajectory(best.feasible ? best_point_ : now_.point);
    return best;
  }

 private:
  static double sum(const std::vector<double>& durations) {
    double total = 0.0;
    for (double T : durations) total += T;
    return total;
  }

  const Bound& bound(int piece, int b) const { return bound_[piece * bounds_ + b]; }

  /// Values and g + e of a piece; false if something is not finite.
  bool evaluate_piece(Trial& trial, int k) {
    sample_piece(unknowns_.ends(trial.point, trial.durations, k), trial.durations[k], table_, flat_);
    PieceState& piece = trial.pieces[k];
    evaluate(constraints_, flat_, piece.values);
    if (!piece.values.allFinite()) return false;
    piece.slack.resize(piece.values.rows(), bounds_);
    for (int b = 0; b < bounds_; ++b) {
      const Bound& at = bound(k, b);
      piece.slack.col(b).array() = at.sign / at.scale * (piece.values.col(at.row).array() - at.limit);
    }
    if (!tightening_.empty()) piece.slack -= tightening_[k];
    return true;
  }

  bool begin() {
    now_.point = unknowns_.start();
    now_.durations = unknowns_.durations(now_.point);
    now_.pieces.resize(problem_.pieces());
    shift_.resize(problem_.pieces());
    dual_.resize(problem_.pieces());
    dual_step_.resize(problem_.pieces());
    slopes_.resize(problem_.pieces());
    time_dual_ = VectorXd(problem_.pieces());
    for (double T : now_.durations) settings_.duration_min = std::min(settings_.duration_min, 0.5 * T);
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (!evaluate_piece(now_, k)) return false;
      MatrixXd& slack = now_.pieces[k].slack;
      shift_[k] = (settings_.shift - slack.array()).max(0.0);
      slack += shift_[k];
      dual_[k] = mu_ / slack.array();
      time_dual_[k] = mu_ / (now_.durations[k] - settings_.duration_min);
    }
    trial_.pieces.resize(problem_.pieces());
    return true;
  }

  double least_margin() const {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < problem_.pieces(); ++k) least = std::min(least, (now_.pieces[k].slack - shift_[k]).minCoeff());
    return least;
  }

  double merit(const Trial& at) const {
    double logs = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      logs += at.pieces[k].slack.array().log().sum() + std::log(10.0 * (at.durations[k] - settings_.duration_min));
    }
    return sum(at.durations) - mu_ * logs;
  }

  // ---- the linear system

  void assemble() {
    hessian_.set_zero();
    gradient_ = VectorXd::Zero(unknowns_.size());
    for (int k = 0; k < problem_.pieces(); ++k) {
      LocalMatrix H;
      LocalVector b, pull = LocalVector::Zero();
      const Ends z = unknowns_.ends(now_.point, now_.durations, k);
      local_system(k, z, H, b);
      if (settings_.curvature > 0.0) add_curvature(k, H, pull);
      scatter(k, z, H, b, pull);
    }
  }

  /// Gauss-Newton matrix and gradient of the barrier of a piece by its tau-derivatives and log duration.
  void local_system(int k, const Ends& z, LocalMatrix& H, LocalVector& b) {
    const double T = now_.durations[k];
    sample_piece(z, T, table_, flat_);
    differentiate(constraints_, flat_, slopes_[k]);
    const auto& rows = constraints_.rows();
    weights(k);
    double scale[kGiven] = {1.0};
    for (int d = 1; d < kGiven; ++d) scale[d] = scale[d - 1] / T;
    factor_.resize(kLocal, table_.count() * static_cast<int>(rows.size()));
    b.setZero();
    int used = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const MatrixXd& slope = slopes_[k][r];
      for (int i = 0; i < table_.count(); ++i) {
        auto J = factor_.col(used);
        J.setZero();
        for (std::size_t e = 0; e < rows[r].entries.size(); ++e) {
          const auto [axis, order] = rows[r].entries[e];
          const double g = slope(i, static_cast<int>(e));
          J.template segment<kOrder>(axis * kOrder) += (g * scale[order]) * table_[order].row(i).transpose();
          J[kTime] -= order * g * flat_[order](i, axis);
        }
        b += force_(i, static_cast<int>(r)) * J;
        J *= std::sqrt(stiffness_(i, static_cast<int>(r)));
        ++used;
      }
    }
    H.setZero();
    H.template selfadjointView<Eigen::Lower>().rankUpdate(factor_.leftCols(used));
    H.template triangularView<Eigen::StrictlyUpper>() = H.transpose();
    const double gap = T - settings_.duration_min;
    b[kTime] += T * (1.0 - mu_ / gap);
    H(kTime, kTime) += std::max(0.0, T * (1.0 - time_dual_[k])) + T * T * time_dual_[k] / gap;
  }

  /// Of each row and sample: z/g (stiffness) and -mu/g (force), summed over its bounds.
  void weights(int k) {
    const MatrixXd& slack = now_.pieces[k].slack;
    stiffness_.setZero(slack.rows(), static_cast<int>(constraints_.rows().size()));
    force_ = stiffness_;
    for (int j = 0; j < bounds_; ++j) {
      const Bound& at = bound(k, j);
      const double c = at.sign / at.scale;
      stiffness_.col(at.row).array() += c * c * dual_[k].col(j).array() / slack.col(j).array();
      force_.col(at.row).array() -= c * mu_ / slack.col(j).array();
    }
  }

  /// Second derivatives of the limited quantities, weighted by their multipliers, by tau-derivatives and log duration;
  /// `pull` is the weighted first derivative, for the second derivatives of the map to the unknowns.
  void add_curvature(int k, LocalMatrix& H, LocalVector& pull) {
    const auto& rows = constraints_.rows();
    force_.setZero();
    for (int j = 0; j < bounds_; ++j) {
      const Bound& at = bound(k, j);
      force_.col(at.row).array() -= settings_.curvature * at.sign / at.scale * dual_[k].col(j).array();
    }
    curvature(constraints_, flat_, force_, hessians_);
    double scale[kGiven] = {1.0};
    for (int d = 1; d < kGiven; ++d) scale[d] = scale[d - 1] / now_.durations[k];
    const int count = table_.count();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (std::size_t e = 0; e < rows[r].entries.size(); ++e) {
        const auto [axis, order] = rows[r].entries[e];
        const VectorXd g = force_.col(static_cast<int>(r)).cwiseProduct(slopes_[k][r].col(static_cast<int>(e)));
        const BasisRow along = scale[order] * (table_[order].transpose() * g);
        pull.template segment<kOrder>(axis * kOrder) += along;
        H.template block<kOrder, 1>(axis * kOrder, kTime) -= order * along;  // q = T^-r Q by tau-derivative and log T
        H(kTime, kTime) += order * order * g.dot(flat_[order].col(axis));
      }
    }
    MatrixXd by_time(count, kDynamicEntries);  // M times the change of q with log T
    for (int i = 0; i < count; ++i) {
      Eigen::Matrix<double, kDynamicEntries, 1> t;
      for (int e = 0; e < kDynamicEntries; ++e) {
        const auto [axis, order] = dynamic_entry(e);
        t[e] = -order * flat_[order](i, axis);
      }
      const Eigen::Matrix<double, kDynamicEntries, 1> Mt = hessians_[i] * t;
      by_time.row(i) = Mt;
      H(kTime, kTime) += t.dot(Mt);
    }
    for (int e = 0; e < kDynamicEntries; ++e) {
      const auto [axis, order] = dynamic_entry(e);
      H.template block<kOrder, 1>(axis * kOrder, kTime) += scale[order] * (table_[order].transpose() * by_time.col(e));
    }
    H.template block<1, kEnds>(kTime, 0) = H.template block<kEnds, 1>(0, kTime).transpose();
    add_axis_blocks(H, scale);
  }

  /// sum over samples of h_r M h_s' for each pair of axes.
  void add_axis_blocks(LocalMatrix& H, const double* scale) {
    const int count = table_.count();
    std::array<std::array<int, 3>, kAxes> entries{};
    for (int e = 0, seen[kAxes] = {}; e < kDynamicEntries; ++e) {
      const int axis = dynamic_entry(e).axis;
      entries[axis][seen[axis]++] = e;
    }
    Eigen::Matrix<double, Eigen::Dynamic, kOrder, Eigen::RowMajor> weighted(count, kOrder);
    for (int a = 0; a < kAxes; ++a) {
      for (int b = 0; b <= a; ++b) {
        Eigen::Matrix<double, kOrder, kOrder> block = Eigen::Matrix<double, kOrder, kOrder>::Zero();
        for (int e : entries[a]) {
          const int r = dynamic_entry(e).order;
          weighted.setZero();
          for (int f : entries[b]) {
            const int s = dynamic_entry(f).order;
            for (int i = 0; i < count; ++i)
              weighted.row(i) += (scale[r] * scale[s] * hessians_[i](e, f)) * table_[s].row(i);
          }
          block.noalias() += table_[r].transpose() * weighted;
        }
        H.template block<kOrder, kOrder>(a * kOrder, b * kOrder) += block;
        if (a != b) H.template block<kOrder, kOrder>(b * kOrder, a * kOrder) += block.transpose();
      }
    }
  }

  /// From local to scaled unknowns, and into the whole system.
  void scatter(int k, const Ends& z, const LocalMatrix& H, const LocalVector& b, const LocalVector& pull) {
    const PieceMap map = unknowns_.map(now_.durations, k);
    const VectorXd& scale = unknowns_.scale();
    int index[kEnds + 3];
    double power[kEnds];
    Eigen::Matrix<double, kLocal, 3> by_time = Eigen::Matrix<double, kLocal, 3>::Zero();
    for (int a = 0; a < kAxes; ++a) {
      for (int row = 0; row < kOrder; ++row) {
        const int i = a * kOrder + row;
        index[i] = unknowns_.index(k, row, a);
        power[i] = index[i] < 0 ? 0.0 : map.power(row, a) * scale[index[i]];
        for (int j = 0; j < 3; ++j) by_time(i, j) = z(row, a) * map.alpha[j](row, a);
      }
    }
    by_time(kTime, 1) = 1.0;
    double time_scale[3];
    for (int j = 0; j < 3; ++j) {
      index[kEnds + j] = unknowns_.time_index(k, j);
      time_scale[j] = index[kEnds + j] < 0 ? 0.0 : scale[index[kEnds + j]];
      by_time.col(j) *= time_scale[j];
    }
    for (int i = 0; i < kEnds; ++i) {
      if (index[i] < 0) continue;
      gradient_[index[i]] += power[i] * b[i];
      for (int j = 0; j <= i; ++j) {
        if (index[j] >= 0) hessian_.add(index[i], index[j], power[i] * power[j] * H(i, j));
      }
    }
    Eigen::Matrix<double, kLocal, 3> H_time = H * by_time;
    Eigen::Matrix3d times = by_time.transpose() * H_time;
    for (int i = 0; i < kEnds; ++i) {  // z = (T/h)^d x exp(alpha . u)
      const int a = i / kOrder, row = i % kOrder;
      for (int j = 0; j < 3; ++j) {
        const int at = index[kEnds + j];
        if (at < 0) continue;
        H_time(i, j) += map.alpha[j](row, a) * time_scale[j] * pull[i];
        for (int l = 0; l < 3; ++l) times(j, l) += by_time(i, j) * pull[i] * map.alpha[l](row, a) * time_scale[l];
      }
    }
    for (int j = 0; j < 3; ++j) {
      const int at = index[kEnds + j];
      if (at < 0) continue;
      gradient_[at] += by_time.col(j).dot(b);
      for (int i = 0; i < kEnds; ++i) {
        if (index[i] >= 0) hessian_.add(at, index[i], power[i] * H_time(i, j));
      }
      for (int l = 0; l < 3; ++l) {  // tied neighbours are one unknown: both off-diagonal terms go to its diagonal
        if (index[kEnds + l] == at || (index[kEnds + l] >= 0 && l < j)) hessian_.add(at, index[kEnds + l], times(j, l));
      }
    }
  }

  // ---- one step

  bool step() {
    const double before = now_.merit = merit(now_);
    double damping = damping_;
    for (int attempt = 0; attempt < kRetries; ++attempt) {
      while (!hessian_.factorise(damping + 1e-11)) {
        damping = std::max(5.0 * damping, 1e-5);
        if (damping > 1e9) return false;
      }
      const VectorXd direction = hessian_.solve(-gradient_);
      decrement_ = -gradient_.dot(direction);
      step_ = direction.cwiseProduct(unknowns_.scale());
      if (search(before)) {
        damping_ = length_ >= 0.9 ? 0.2 * damping : length_ > 0.3 ? 2.0 * damping : std::max(3.0 * damping, 1e-5);
        if (damping_ < 1e-9) damping_ = 0.0;
        accept();
        return true;
      }
      damping = std::max(8.0 * damping, 1e-4);
    }
    return false;
  }

  /// Shorter and shorter along step_; the accepted point is left in trial_.
  bool search(double before) {
    length_ = 1.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      const double change = std::abs(step_[unknowns_.time_index(k, 1)]);
      if (length_ * change > kLongestTimeStep) length_ = kLongestTimeStep / change;
    }
    for (int cut = 0; cut < kCuts; ++cut, length_ *= kCut) {
      trial_.point = unknowns_.moved(now_.point, step_, length_);
      trial_.durations = unknowns_.durations(trial_.point);
      if (!inside()) continue;
      trial_.merit = merit(trial_);
      if (trial_.merit <= before - 1e-4 * length_ * decrement_ + 1e-12) return true;
    }
    return false;
  }

  bool inside() {
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (!(trial_.durations[k] > settings_.duration_min) || !evaluate_piece(trial_, k)) return false;
      trial_.pieces[k].slack += shift_[k];
      if (!(trial_.pieces[k].slack.array() > kBoundary * now_.pieces[k].slack.array()).all()) return false;
    }
    return true;
  }

  void accept() {
    const double dual_length = dual_direction();
    std::swap(now_, trial_);
    largest_shift_ = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      auto slack = now_.pieces[k].slack.array();
      auto shift = shift_[k].array();
      const Eigen::ArrayXXd smaller = (shift - 0.5 * slack).max(0.0);
      slack += smaller - shift;
      shift = smaller;
      largest_shift_ = std::max(largest_shift_, shift.maxCoeff());
      const Eigen::ArrayXXd centre = mu_ / slack;
      dual_[k] = (dual_[k] + dual_length * dual_step_[k]).array().max(1e-3 * centre).min(1e3 * centre);
      const double gap = mu_ / (now_.durations[k] - settings_.duration_min);
      time_dual_[k] = std::clamp(time_dual_[k] + dual_length * time_dual_step_[k], 1e-3 * gap, 1e3 * gap);
    }
  }

  /// Change of the multipliers for the accepted step; returns how far they may go and stay positive.
  double dual_direction() {
    double longest = 1.0;
    time_dual_step_ = VectorXd(problem_.pieces());
    const auto& rows = constraints_.rows();
    for (int k = 0; k < problem_.pieces(); ++k) {
      const Ends z = unknowns_.ends(now_.point, now_.durations, k);
      const double T = now_.durations[k];
      Ends dz;
      double dlog_T = 0.0;
      local_step(k, z, dz, dlog_T);
      sample_piece(z, T, table_, flat_);
      sample_piece(dz, T, table_, flat_step_);
      const MatrixXd& slack = now_.pieces[k].slack;
      MatrixXd change = MatrixXd::Zero(slack.rows(), static_cast<int>(rows.size()));
      for (std::size_t r = 0; r < rows.size(); ++r) {
        for (std::size_t e = 0; e < rows[r].entries.size(); ++e) {
          const auto [axis, order] = rows[r].entries[e];
          change.col(r).array() += slopes_[k][r].col(e).array() * (flat_step_[order].col(axis).array() -
                                                                   order * dlog_T * flat_[order].col(axis).array());
        }
      }
      dual_step_[k].resize(slack.rows(), bounds_);
      for (int j = 0; j < bounds_; ++j) {
        const Bound& at = bound(k, j);
        const auto g = slack.col(j).array();
        const auto multiplier = dual_[k].col(j).array();
        dual_step_[k].col(j) = (mu_ - multiplier * (at.sign / at.scale) * change.col(at.row).array()) / g - multiplier;
      }
      longest = std::min(longest, 1.0 / std::max(1.0, (-dual_step_[k].array() / dual_[k].array()).maxCoeff() / 0.99));
      const double gap = T - settings_.duration_min, multiplier = time_dual_[k];
      time_dual_step_[k] = (mu_ - multiplier * T * dlog_T) / gap - multiplier;
      longest = std::min(longest, 1.0 / std::max(1.0, -time_dual_step_[k] / multiplier / 0.99));
    }
    return longest;
  }

  /// What the whole step changes in the tau-derivatives and the log duration of a piece.
  void local_step(int k, const Ends& z, Ends& dz, double& dlog_T) const {
    const PieceMap map = unknowns_.map(now_.durations, k);
    dz.setZero();
    for (int j = 0; j < 3; ++j) {
      const int at = unknowns_.time_index(k, j);
      if (at < 0) continue;
      dz += step_[at] * map.alpha[j].cwiseProduct(z);
      if (j == 1) dlog_T = step_[at];
    }
    for (int a = 0; a < kAxes; ++a) {
      for (int row = 0; row < kOrder; ++row) {
        const int at = unknowns_.index(k, row, a);
        if (at >= 0) dz(row, a) += map.power(row, a) * step_[at];
      }
    }
  }

  const Problem& problem_;
  const Constraints& constraints_;
  const Tightening& tightening_;
  SolverSettings settings_;
  const SampleTable table_;
  const Unknowns unknowns_;
  Skyline hessian_;
  const int bounds_;
  std::vector<Bound> bound_;  // by piece

  double mu_ = 0.0, damping_ = 1e-4, length_ = 0.0, decrement_ = 0.0, largest_shift_ = 0.0;
  int stuck_ = 0;
  Trial now_, trial_;
  Point best_point_;
  std::vector<MatrixXd> shift_, dual_, dual_step_;  // (samples, bounds) of each piece
  VectorXd time_dual_, time_dual_step_;
  std::vector<std::vector<MatrixXd>> slopes_;  // by piece and row
  VectorXd gradient_, step_;
  FlatSamples flat_, flat_step_;
  MatrixXd stiffness_, force_;
  std::vector<DynamicMatrix> hessians_;
  Eigen::Matrix<double, kLocal, Eigen::Dynamic> factor_;
};

}  // namespace

Solution minimise_time(const Problem& problem, const Constraints& constraints, const Tightening& tightening,
                       const SolverSettings& settings, const Progress& progress) {
  return InteriorPoint(problem, constraints, tightening, settings).solve(progress);
}

}  // namespace halfroll::planner
