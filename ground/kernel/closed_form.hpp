// The closed form (Eqs 23-24): the polynomials of 9th order through nodes in given times, and their exact slopes.
//
// Why it is linear in the number of nodes: the unknowns are the free derivatives at the nodes, not the coefficients of
// the pieces, so the pieces meet by construction and what is left to ask for couples neighbours only.
//
// Continuity 8 is the paper's form: at a node with k derivatives given, all others up to the (9-k)-th are continuous.
// At an end, a derivative d < 5 that is free has derivative 9-d zero. With k = 0..5 lowest derivatives given
// everywhere, this is also the path of least crackle (the integral of the squared 5th derivative). With continuity 4..7
// derivatives above it may jump, and what that leaves open makes the integral of the squared snap least.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "certificate.hpp"
#include "trajectory.hpp"

namespace halfroll::planner {

/// What a node is unknown in, or asked for: 0..4 are its derivatives, 5..9 the jumps of derivatives 5..9 there.
struct Slots {
  int count = 0;
  std::array<std::int8_t, 2 * kGiven> at;
  void add(int slot) { at[count++] = static_cast<std::int8_t>(slot); }
};

class ClosedForm {
 public:
  /// given: NaN where free; durations > 0; continuity 4..8.
  ClosedForm(std::vector<Node> given, std::vector<double> durations, int continuity);

  /// Whether what is given determines a path; if not, `stuck` is about where it fails.
  bool solved() const { return stuck_ < 0; }
  int stuck() const { return stuck_; }
  const std::vector<Node>& nodes() const { return values_; }
  const std::vector<double>& durations() const { return durations_; }
  int pieces() const { return static_cast<int>(durations_.size()); }
  Coefficients coefficients(int piece) const;
  /// Of the eliminated rows, the largest of all that is kept meanwhile.
  std::size_t bytes() const { return bytes_; }

  struct Slopes {
    std::vector<double> durations;
    std::vector<Node> given;  // zero where a derivative is free
  };
  /// Slopes of a cost over durations and given derivatives, from its slopes over the coefficients of each piece.
  Slopes slopes(const std::vector<Coefficients>& cost) const;

 private:
  struct Layout {  // of axes with the same derivatives given, which share one elimination
    std::array<bool, kAxes> axes{};
    std::vector<Slots> unknowns, equations, given;  // of each node
    int block = 0;                                  // the most unknowns of a node
  };
  std::vector<Layout> layouts() const;
  template <int B>
  bool solve(const Layout& layout);
  bool solve_4(const Layout& layout);
  bool solve_5(const Layout& layout);
  bool solve_8(const Layout& layout);

  std::vector<double> durations_;
  int continuity_;
  std::vector<Node> values_;  // all derivatives; before, NaN where free
  std::vector<Layout> layouts_;
  std::vector<Node> multipliers_;  // of the jumps of derivatives 5..9, in units of their own; continuity below 8
  int stuck_ = -1;
  std::size_t bytes_ = 0;
};

}  // namespace halfroll::planner
