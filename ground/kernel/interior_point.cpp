#include "interior_point.hpp"

#include <algorithm>
#include <cmath>

#include "chain.hpp"
#include "pack.hpp"
#include "peaks.hpp"
#include "piece_system.hpp"

namespace halfroll::planner {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastShare = 0.05;      // of the shifts, that a step is asked to remove
constexpr double kShiftSmall = 1e-3;      // mu is not reduced while shifts are larger
constexpr double kDecrement = 10.0;       // mu is reduced once the Newton decrement is below this times mu
constexpr double kLongestTimeStep = 0.5;  // of a log duration
constexpr double kBoundary = 0.01;        // share of a margin that a step must leave
constexpr double kElastic = 0.3;          // the same while shifts are not small, and what falls short is shifted
constexpr int kPatience = 40;             // steps in which the shifts must shrink, if they ever will
constexpr double kMostDamping = 1e6, kDampingAgain = 1e-2;
constexpr int kCuts = 7, kRetries = 12, kRounds = 8;
constexpr double kLongBefore = 1.002;
constexpr double kShiftCost = 3.0;  // times a bound's multiplier
constexpr double kCut = 0.6;
constexpr double kLong = 0.4;      // a step at least this long may end a stage of mu
constexpr double kTouched = 0.02;  // margin of a bound that holds the path back; others have multipliers of mu alone

/// All that is known of a piece at one point.
struct PieceState {
  FlatSamples flat;
  MatrixXd values;  // (samples, rows)
  MatrixXd slack;   // (samples, bounds) g + e
  MatrixXd shift;   // e
};

struct Trial {
  Point point;
  std::vector<double> durations;
  std::vector<PieceState> pieces;
  double merit = 0.0;
};

/// Sum of logs, by the logs of products of sixteen: margins are far from the ends of the range of numbers.
HALFROLL_WIDE double log_sum(const double* x, int count) {
  double total = 0.0;
  for (int i = 0; i < count;) {
    Pack product = splat(1.0);
    for (const int end = std::min(count, i + 16 * Pack::kWidth); i < end; i += Pack::kWidth)
      product = product * load(x + i);
    for (int lane = 0; lane < Pack::kWidth; ++lane) total += std::log(product.v[lane]);
  }
  return total;
}

class InteriorPoint {
 public:
  InteriorPoint(const Problem& problem, const Constraints& constraints, const SolverSettings& settings)
      : problem_(problem),
        constraints_(constraints),
        settings_(settings),
        table_(settings.samples, constraints.limits_rates()),
        unknowns_(problem),
        assembly_(constraints, table_),
        fine_(constraints, settings.samples),
        hessian_(unknowns_.group()),
        bounds_(static_cast<int>(constraints.bounds().size())) {
    for (int k = 0; k < problem.pieces(); ++k) {
      for (int b = 0; b < bounds_; ++b) bound_.push_back(constraints.on_piece(b, problem.limits[k]));
    }
  }

  Solution solve(const Progress& progress) {
    Solution best;
    best.trajectory = problem_.start;
    const double bounds = static_cast<double>(problem_.pieces()) * settings_.samples * bounds_;
    const double barrier_end = settings_.gap_end * problem_.start.total() / bounds;
    mu_ = settings_.gap_start * problem_.start.total() / bounds;
    if (!begin()) return best;
    double fastest = std::numeric_limits<double>::infinity();
    const auto keep = [&] {
      if (sum(now_.durations) > fastest) return;
      fastest = sum(now_.durations);
      best_point_ = now_.point;
      best.feasible = true;
    };
    int rounds = 0, shrunk = 0;
    double shift = largest_shift_;
    for (best.iterations = 0; best.iterations < settings_.iterations; ++best.iterations) {
      if (settings_.spare == 0.0 && least_margin() >= 0.0) keep();
      if (progress && !progress(fastest)) {
        best.interrupted = true;
        break;
      }
      if (largest_shift_ < 0.7 * shift || !elastic()) {
        shift = largest_shift_;
        shrunk = best.iterations;
      } else if (best.iterations > shrunk + kPatience) {
        break;
      }
      assemble();
      if (!step()) {
        mu_ *= 0.3;
        if (++stuck_ > 3) break;
        continue;
      }
      if (decrement_ > std::max(kDecrement * mu_ * std::max(1.0, problem_.pieces() / 100.0),
                                settings_.negligible * sum(now_.durations)) ||
          length_ < kLong || largest_shift_ > kShiftSmall) {
        continue;
      }
      const bool last_stage = mu_ <= barrier_end, last = last_stage && largest_shift_ == 0.0;
      mu_ = std::max(mu_ * settings_.gap_factor, barrier_end);
      if (settings_.spare > 0.0) {
        const double least = look_between(last_stage);
        shift = largest_shift_;
        shrunk = best.iterations;
        if (least >= 0.0) keep();
        if (last && (least >= 0.5 * settings_.spare || ++rounds == kRounds)) break;
      } else if (last) {
        break;
      }
    }
    if (settings_.spare > 0.0 ? look_between(false) >= 0.0 : least_margin() >= 0.0) keep();
    // One that sticks out by little is worth more than one from long before.
    if (!best.interrupted && fastest > kLongBefore * sum(now_.durations)) best.feasible = false;
    best.trajectory = unknowns_.trajectory(best.feasible ? best_point_ : now_.point);
    best.push_price = push_price();
    return best;
  }

 private:
  /// While some limits are outside by much, none is a wall.
  bool elastic() const { return settings_.elastic && largest_shift_ > kShiftSmall; }

  static double sum(const std::vector<double>& durations) {
    double total = 0.0;
    for (double T : durations) total += T;
    return total;
  }

  const Bound& bound(int piece, int b) const { return bound_[piece * bounds_ + b]; }

  /// Values and g + e of a piece; false if something is not finite.
  bool evaluate_piece(Trial& trial, int k) {
    PieceState& piece = trial.pieces[k];
    sample_piece(unknowns_.ends(trial.point, trial.durations, k), trial.durations[k], table_, piece.flat);
    evaluate(constraints_, problem_.limits[k], piece.flat, piece.values);
    if (!piece.values.allFinite()) return false;
    piece.slack.resize(piece.values.rows(), bounds_);
    for (int b = 0; b < bounds_; ++b) {
      const Bound& at = bound(k, b);
      piece.slack.col(b).array() = at.sign / at.scale * (piece.values.col(at.row).array() - at.limit);
    }
    piece.slack -= tightening_[k];
    return true;
  }

  bool begin() {
    now_.point = unknowns_.start();
    now_.durations = unknowns_.durations(now_.point);
    now_.pieces.resize(problem_.pieces());
    dual_.resize(problem_.pieces());
    dual_step_.resize(problem_.pieces());
    slopes_.resize(problem_.pieces());
    time_dual_ = VectorXd(problem_.pieces());
    for (double T : now_.durations) settings_.duration_min = std::min(settings_.duration_min, 0.5 * T);
    tightening_.assign(problem_.pieces(), MatrixXd::Zero(settings_.samples, bounds_));
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (!evaluate_piece(now_, k)) return false;
      PieceState& piece = now_.pieces[k];
      piece.shift = (settings_.shift - piece.slack.array()).max(0.0);
      piece.slack += piece.shift;
      largest_shift_ = std::max(largest_shift_, piece.shift.maxCoeff());
      time_dual_[k] = mu_ / (now_.durations[k] - settings_.duration_min);
    }
    if (settings_.spare > 0.0) look_between(false);
    for (int k = 0; k < problem_.pieces(); ++k) dual_[k] = mu_ / now_.pieces[k].slack.array();
    trial_.pieces.resize(problem_.pieces());
    return true;
  }

  /// The multipliers of the least rotor thrusts that are touched.
  double push_price() const {
    double price = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      for (int b = 0; b < bounds_; ++b) {
        const Bound& at = bound(k, b);
        if (at.sign < 0.0 || !constraints_.rows()[at.row].of_rotor()) continue;
        price += (now_.pieces[k].slack.col(b).array() < kTouched).select(dual_[k].col(b).array(), 0.0).sum() / at.scale;
      }
    }
    return price;
  }

  double least_margin() const {
    double least = std::numeric_limits<double>::infinity();
    for (const PieceState& piece : now_.pieces) least = std::min(least, (piece.slack - piece.shift).minCoeff());
    return least;
  }

  /// Of a piece at its samples, whatever is asked of them.
  MatrixXd margins(int k) const { return now_.pieces[k].slack - now_.pieces[k].shift + tightening_[k]; }

  /// Asks for as much more at the samples as the margins fall between them, and `at_least` for what was asked before:
  /// peaks that come and go with it would never settle. Returns the least margin between samples.
  double look_between(bool at_least) {
    double least = std::numeric_limits<double>::infinity();
    std::vector<MatrixXd> asked(problem_.pieces(), MatrixXd::Constant(settings_.samples, bounds_, settings_.spare));
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (!fine_.look(unknowns_.ends(now_.point, now_.durations, k), now_.durations[k], problem_.limits[k],
                      &bound(k, 0))) {
        return -std::numeric_limits<double>::infinity();
      }
      const MatrixXd at = margins(k), &between = fine_.least();
      const bool last = k + 1 == problem_.pieces();
      const MatrixXd next = last ? MatrixXd() : margins(k + 1);
      for (int b = 0; b < bounds_; ++b) {
        for (int i = 0; i < fine_.intervals(); ++i) {
          const bool inner = i + 1 < settings_.samples;
          const double after = inner ? at(i + 1, b) : last ? at(i, b) : next(0, b);
          const double ends = std::min(at(i, b), after);
          least = std::min({least, ends, between(i, b)});
          const double more = std::max(0.0, ends - between(i, b)) + settings_.spare;
          asked[k](i, b) = std::max(asked[k](i, b), more);
          if (inner) asked[k](i + 1, b) = std::max(asked[k](i + 1, b), more);
          if (!inner && !last) asked[k + 1](0, b) = std::max(asked[k + 1](0, b), more);
        }
      }
    }
    largest_shift_ = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (at_least) asked[k] = asked[k].cwiseMax(tightening_[k]);
      auto slack = now_.pieces[k].slack.array(), shift = now_.pieces[k].shift.array();
      const Eigen::ArrayXXd margin = slack - shift + tightening_[k].array() - asked[k].array();
      shift = (slack - margin).max(0.0);
      slack = margin + shift;
      largest_shift_ = std::max(largest_shift_, shift.maxCoeff());
    }
    tightening_ = std::move(asked);
    return least;
  }

  /// What a step must reduce. Shifts cost more than shrinking them can cost in time.
  double merit(const Trial& at) const {
    double logs = 0.0, shifts = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      const PieceState& piece = at.pieces[k];
      logs += log_sum(piece.slack.data(), static_cast<int>(piece.slack.size()));
      logs += std::log(10.0 * (at.durations[k] - settings_.duration_min));
      if (largest_shift_ > 0.0) shifts += dual_[k].cwiseProduct(piece.shift).sum();
    }
    return sum(at.durations) - mu_ * logs + kShiftCost * shifts;
  }

  // ---- the linear system

  void assemble() {
    gradient_ = VectorXd::Zero(unknowns_.size());
    for (int k = 0; k < problem_.pieces(); ++k) {
      const double T = now_.durations[k], gap = T - settings_.duration_min;
      const FlatSamples& flat = now_.pieces[k].flat;
      differentiate(constraints_, problem_.limits[k], flat, slopes_[k]);
      weigh(k);
      assembly_.assemble(flat, slopes_[k], T, stiffness_, force_, curved_, system_);
      system_.time_gradient += T * (1.0 - mu_ / gap);
      system_.time_time += std::max(0.0, T * (1.0 - time_dual_[k])) + T * T * time_dual_[k] / gap;
      scatter(k);
    }
  }

  /// Of each row and sample, summed over its bounds: z/g (stiffness), -(mu + z e)/g (force), z times the share
  /// of curvature.
  void weigh(int k) {
    const MatrixXd &slack = now_.pieces[k].slack, &shift = now_.pieces[k].shift;
    stiffness_.setZero(slack.rows(), static_cast<int>(constraints_.rows().size()));
    force_ = stiffness_;
    if (settings_.curvature > 0.0) curved_ = stiffness_;
    for (int j = 0; j < bounds_; ++j) {
      const Bound& at = bound(k, j);
      const double c = at.sign / at.scale;
      stiffness_.col(at.row).array() += c * c * dual_[k].col(j).array() / slack.col(j).array();
      force_.col(at.row).array() -=
          c * (mu_ + share_ * dual_[k].col(j).array() * shift.col(j).array()) / slack.col(j).array();
      if (settings_.curvature > 0.0) curved_.col(at.row) -= settings_.curvature * c * dual_[k].col(j);
    }
  }

  /// From tau-derivatives to scaled unknowns, z = (T/h)^d x exp(alpha . u), and into the whole system.
  void scatter(int k) {
    const Ends z = unknowns_.ends(now_.point, now_.durations, k);
    const PieceMap map = unknowns_.map(now_.durations, k);
    const VectorXd& scale = unknowns_.scale();
    const int node = unknowns_.node(k), own = unknowns_.group()[k];
    Front& front = hessian_.piece(k);
    front = {};
    const auto place = [](int row, int a) { return row / kGiven * kNode + a * kGiven + row % kGiven; };
    Ends power;
    for (int a = 0; a < kAxes; ++a) {
      for (int row = 0; row < kOrder; ++row) {
        power(row, a) = map.power(row, a) * scale[node + place(row, a)];
        gradient_[node + place(row, a)] += power(row, a) * system_.gradient[a][row];
      }
      for (int b = 0; b <= a; ++b) {
        for (int row = 0; row < kOrder; ++row) {
          for (int column = 0; column < kOrder; ++column) {
            const int i = place(row, a), j = place(column, b);
            front(std::min(i, j), std::max(i, j)) =
                power(row, a) * power(column, b) * system_.block[a][b][row * PieceSystem::kRow + column];
          }
        }
      }
    }
    Ends along[3], product[3];  // change of z with each duration, and the matrix times it
    double itself[3], crossed[3];
    for (int j = 0; j < 3; ++j) {
      const int group = map.times[j].group;
      if (group < 0 || group >= hessian_.groups()) continue;
      const double unit = scale[unknowns_.time(group)];
      itself[j] = group == own ? unit : 0.0;
      along[j] = unit * map.times[j].alpha.cwiseProduct(z);
      system_.multiply(along[j], product[j]);
      double slope = itself[j] * system_.time_gradient;
      crossed[j] = itself[j] * system_.time_time;
      for (int a = 0; a < kAxes; ++a) {
        for (int row = 0; row < kOrder; ++row) {
          slope += along[j](row, a) * system_.gradient[a][row];
          crossed[j] += along[j](row, a) * system_.by_time[a][row];
          product[j](row, a) +=
              itself[j] * system_.by_time[a][row] + unit * map.times[j].alpha(row, a) * system_.pull[a][row];
          front(place(row, a), Chain::place(group)) = power(row, a) * product[j](row, a);
        }
      }
      gradient_[unknowns_.time(group)] += slope;
      for (int l = 0; l <= j; ++l) {
        if (map.times[l].group < 0) continue;
        const int one = Chain::place(group), other = Chain::place(map.times[l].group);
        front(std::min(one, other), std::max(one, other)) =
            along[l].cwiseProduct(product[j]).sum() + itself[l] * crossed[j];
      }
    }
  }

  // ---- one step

  /// With the shifts in one go if it can be; where that points nowhere, with a part of them, and in the end as they
  /// are.
  bool step() {
    while (!step_with_share()) {
      if (largest_shift_ == 0.0 || share_ == 0.0) return false;
      share_ = share_ > kLeastShare ? 0.25 * share_ : 0.0;
      assemble();
    }
    if (length_ > 0.5) share_ = std::min(1.0, std::max(2.0 * share_, kLeastShare));
    return true;
  }

  bool step_with_share() {
    const double before = now_.merit = merit(now_);
    double damping = damping_;
    for (int attempt = 0; attempt < kRetries; ++attempt) {
      if (!hessian_.factorise(damping + 1e-11)) return false;
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
      if (damping > kMostDamping) break;
    }
    damping_ = std::min(damping_, kDampingAgain);
    return false;
  }

  /// Shorter and shorter along step_; the accepted point is left in trial_.
  bool search(double before) {
    length_ = 1.0;
    const double change = step_.tail(now_.point.u.size()).cwiseAbs().maxCoeff();
    if (change > kLongestTimeStep) length_ = kLongestTimeStep / change;
    for (int cut = 0; cut < kCuts; ++cut, length_ *= kCut) {
      trial_.point = unknowns_.moved(now_.point, step_, length_);
      trial_.durations = unknowns_.durations(trial_.point);
      if (!inside()) continue;
      trial_.merit = merit(trial_);
      if (trial_.merit <= before - length_ * 1e-4 * decrement_ + 1e-12) return true;
    }
    return false;
  }

  /// Whether the trial leaves room everywhere. An elastic limit that the step falls short of, being curved, is shifted,
  /// at a cost, and steps stay long.
  bool inside() {
    for (int k = 0; k < problem_.pieces(); ++k) {
      if (!(trial_.durations[k] > settings_.duration_min) || !evaluate_piece(trial_, k)) return false;
      const auto before = now_.pieces[k].slack.array();
      auto slack = trial_.pieces[k].slack.array();
      trial_.pieces[k].shift = (1.0 - length_ * share_) * now_.pieces[k].shift;
      auto shift = trial_.pieces[k].shift.array();
      slack += shift;
      if (elastic()) {
        shift += (kElastic * before - slack).max(0.0);
        slack = slack.max(kElastic * before);
      } else if (!(slack > kBoundary * before).all()) {
        return false;
      }
    }
    return true;
  }

  void accept() {
    const double dual_length = dual_direction();  // with shifts as they were
    std::swap(now_, trial_);
    const bool stretched = elastic();
    largest_shift_ = 0.0;
    for (int k = 0; k < problem_.pieces(); ++k) {
      auto slack = now_.pieces[k].slack.array();
      auto shift = now_.pieces[k].shift.array();
      if (!stretched) {  // small ones are taken out of the slack at once
        const Eigen::ArrayXXd smaller = (shift - 0.5 * slack).max(0.0);
        slack += smaller - shift;
        shift = smaller;
      }
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
      const double T = now_.durations[k];
      const FlatSamples& flat = now_.pieces[k].flat;
      double dlog_T = 0.0;
      sample_piece(local_step(k, dlog_T), T, table_, flat_step_);
      for (int d = 1; d < kGiven; ++d) flat_step_[d] -= d * dlog_T * flat[d];
      const MatrixXd &slack = now_.pieces[k].slack, &shift = now_.pieces[k].shift;
      MatrixXd change = MatrixXd::Zero(slack.rows(), static_cast<int>(rows.size()));
      for (std::size_t r = 0; r < rows.size(); ++r) {
        for (std::size_t e = 0; e < rows[r].entries.size(); ++e) {
          const auto [axis, order] = rows[r].entries[e];
          change.col(r) += slopes_[k][r].col(e).cwiseProduct(flat_step_[order].col(axis));
        }
      }
      dual_step_[k].resize(slack.rows(), bounds_);
      for (int j = 0; j < bounds_; ++j) {
        const Bound& at = bound(k, j);
        const auto g = slack.col(j).array();
        const auto multiplier = dual_[k].col(j).array();
        dual_step_[k].col(j) =
            (mu_ - multiplier * (at.sign / at.scale * change.col(at.row).array() - share_ * shift.col(j).array())) / g -
            multiplier;
      }
      longest = std::min(longest, 1.0 / std::max(1.0, (-dual_step_[k].array() / dual_[k].array()).maxCoeff() / 0.99));
      const double gap = T - settings_.duration_min, multiplier = time_dual_[k];
      time_dual_step_[k] = (mu_ - multiplier * T * dlog_T) / gap - multiplier;
      longest = std::min(longest, 1.0 / std::max(1.0, -time_dual_step_[k] / multiplier / 0.99));
    }
    return longest;
  }

  /// What the whole step changes in the tau-derivatives and the log duration of a piece.
  Ends local_step(int k, double& dlog_T) const {
    const PieceMap map = unknowns_.map(now_.durations, k);
    const Ends z = unknowns_.ends(now_.point, now_.durations, k);
    Ends dz;
    dz.topRows<kGiven>() = Eigen::Map<const Node>(step_.data() + unknowns_.node(k));
    dz.bottomRows<kGiven>() = Eigen::Map<const Node>(step_.data() + unknowns_.node(k + 1));
    dz = dz.cwiseProduct(map.power).eval();
    for (const PieceMap::Time& time : map.times) {
      if (time.group < 0 || time.group >= hessian_.groups()) continue;
      dz += step_[unknowns_.time(time.group)] * time.alpha.cwiseProduct(z);
    }
    dlog_T = step_[unknowns_.time(unknowns_.group()[k])];
    return dz;
  }

  const Problem& problem_;
  const Constraints& constraints_;
  SolverSettings settings_;
  const SampleTable table_;
  const Unknowns unknowns_;
  PieceAssembly assembly_;
  FineGrid fine_;
  PieceSystem system_;
  Chain hessian_;
  const int bounds_;
  std::vector<Bound> bound_;  // by piece

  double share_ = 1.0;  // of the shifts that a whole step removes
  double mu_ = 0.0, damping_ = 1e-4, length_ = 0.0, decrement_ = 0.0, largest_shift_ = 0.0;
  int stuck_ = 0;
  Trial now_, trial_;
  Point best_point_;
  std::vector<MatrixXd> tightening_, dual_, dual_step_;  // (samples, bounds) of each piece
  VectorXd time_dual_, time_dual_step_;
  std::vector<std::vector<MatrixXd>> slopes_;  // by piece and row
  VectorXd gradient_, step_;
  FlatSamples flat_step_;
  MatrixXd stiffness_, force_, curved_;  // (samples, rows) of the piece that is assembled
};

}  // namespace

Solution minimise_time(const Problem& problem, const Constraints& constraints, const SolverSettings& settings,
                       const Progress& progress) {
  return InteriorPoint(problem, constraints, settings).solve(progress);
}

}  // namespace halfroll::planner
