// The planner's kernel for Python: a module of its own, so that planning needs no firmware.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "kernel/certificate.hpp"
#include "kernel/interior_point.hpp"
#include "kernel/peaks.hpp"
#include "kernel/planar_certificate.hpp"

void bind_closed_form(pybind11::module_& m);

namespace {

namespace py = pybind11;
using namespace pybind11::literals;
using namespace halfroll::planner;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Flags = py::array_t<bool, py::array::c_style | py::array::forcecast>;

std::vector<Node> nodes_from(const Array& array) {
  const auto in = array.unchecked<3>();
  std::vector<Node> nodes(in.shape(0));
  for (py::ssize_t k = 0; k < in.shape(0); ++k) {
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) nodes[k](d, a) = in(k, d, a);
    }
  }
  return nodes;
}

std::vector<Mask> masks_from(const Flags& array) {
  const auto in = array.unchecked<3>();
  std::vector<Mask> masks(in.shape(0));
  for (py::ssize_t k = 0; k < in.shape(0); ++k) {
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) masks[k](d, a) = in(k, d, a);
    }
  }
  return masks;
}

Array nodes_to(const std::vector<Node>& nodes) {
  Array array(
      {static_cast<py::ssize_t>(nodes.size()), static_cast<py::ssize_t>(kGiven), static_cast<py::ssize_t>(kAxes)});
  auto out = array.mutable_unchecked<3>();
  for (py::ssize_t k = 0; k < out.shape(0); ++k) {
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) out(k, d, a) = nodes[k](d, a);
    }
  }
  return array;
}

Array coefficients_of(const Trajectory& path) {
  Array array(
      {static_cast<py::ssize_t>(path.pieces()), static_cast<py::ssize_t>(kOrder), static_cast<py::ssize_t>(kAxes)});
  auto out = array.mutable_unchecked<3>();
  for (int k = 0; k < path.pieces(); ++k) {
    const Ends coefficients = hermite_matrix() * path.ends(k);
    for (int i = 0; i < kOrder; ++i) {
      for (int a = 0; a < kAxes; ++a) out(k, i, a) = coefficients(i, a);
    }
  }
  return array;
}

std::vector<Coefficients> pieces_from(const Array& array) {
  const auto in = array.unchecked<3>();
  std::vector<Coefficients> pieces(in.shape(0));
  for (py::ssize_t k = 0; k < in.shape(0); ++k) {
    for (int i = 0; i < kOrder; ++i) {
      for (int a = 0; a < kAxes; ++a) pieces[k](i, a) = in(k, i, a);
    }
  }
  return pieces;
}

void bind_values(py::module_& m) {
  py::class_<Vehicle>(m, "Vehicle", "What thrust depends on; SI, inertia (3,) about body axes.")
      .def(py::init([](double mass, const std::array<double, 3>& inertia, double arm, double yaw_coefficient,
                       double gravity) { return Vehicle{mass, inertia, arm, yaw_coefficient, gravity}; }),
           py::kw_only(), "mass"_a, "inertia"_a, "arm"_a, "yaw_coefficient"_a, "gravity"_a);

  py::class_<Drive>(m, "Drive", "How rotors follow their commands [N]; see halfroll.planner.limits.Drive.")
      .def(py::init([](double lag_up, double lag_down, bool of_speed, double command_min, double command_max) {
             return Drive{lag_up, lag_down, of_speed, command_min, command_max};
           }),
           "lag_up"_a = 0.0, "lag_down"_a = 0.0, "of_speed"_a = false, "command_min"_a = -kNoLimit,
           "command_max"_a = kNoLimit);

  py::class_<Heading>(m, "Heading", "Where the nose points, within an angle: along the path, or towards a point [m].")
      .def(py::init<>())
      .def_static(
          "path", [](double cosine, double slack) { return Heading{Heading::Rule::kPath, cosine, slack}; }, "cosine"_a,
          "slack"_a)
      .def_static(
          "towards",
          [](double x, double y, double cosine, double slack) {
            return Heading{Heading::Rule::kPoint, cosine, slack, x, y};
          },
          "x"_a, "y"_a, "cosine"_a, "slack"_a);

  py::class_<Limits>(m, "Limits", "Infinite: switched off. SI; see halfroll.planner.limits.Limits.")
      .def(py::init([](double rotor_min, double rotor_max, double force_min, double force_z_min, double body_rate_max,
                       double floor, bool vertical, double rotor_rate_max, const Drive& drive, double tilt_cos_min,
                       double ceiling, const Heading& heading) {
             Limits limits;
             limits.rotor_min = rotor_min;
             limits.rotor_max = rotor_max;
             limits.force_min = force_min;
             limits.force_z_min = force_z_min;
             limits.body_rate_max = body_rate_max;
             limits.floor = floor;
             limits.vertical = vertical;
             limits.rotor_rate_max = rotor_rate_max;
             limits.drive = drive;
             limits.tilt_cos_min = tilt_cos_min;
             limits.ceiling = ceiling;
             limits.heading = heading;
             return limits;
           }),
           py::kw_only(), "rotor_min"_a, "rotor_max"_a, "force_min"_a = -kNoLimit, "force_z_min"_a = -kNoLimit,
           "body_rate_max"_a = kNoLimit, "floor"_a = -kNoLimit, "vertical"_a = false, "rotor_rate_max"_a = kNoLimit,
           "drive"_a = Drive{}, "tilt_cos_min"_a = -kNoLimit, "ceiling"_a = kNoLimit, "heading"_a = Heading{});

  py::class_<Constraints>(m, "Constraints", "The rows that a vehicle and its limits make.")
      .def(py::init<const Vehicle&, const Limits&, bool, int>(), "vehicle"_a, "limits"_a, "any_speed_limit"_a,
           "walls"_a = 0);

  py::class_<PieceLimits>(m, "PieceLimits",
                          "What differs from leg to leg: speed [m/s], and walls (x, y, offset) that are not crossed.")
      .def(py::init([](double speed_max, const std::vector<std::array<double, 3>>& walls) {
             PieceLimits piece{speed_max, {}};
             for (const auto& [x, y, offset] : walls) piece.walls.push_back({x, y, offset});
             return piece;
           }),
           "speed_max"_a = kNoLimit, "walls"_a = std::vector<std::array<double, 3>>{})
      .def_readonly("speed_max", &PieceLimits::speed_max)
      .def_property_readonly("walls", [](const PieceLimits& piece) {
        std::vector<std::array<double, 3>> walls;
        for (const Wall& wall : piece.walls) walls.push_back({wall.x, wall.y, wall.offset});
        return walls;
      });
}

void bind_problem(py::module_& m) {
  py::class_<Problem>(m, "Problem",
                      "A trajectory to improve: N pieces, nodes (N+1, 5, 4) derivatives 0..4 of x, y, z, yaw.")
      .def(py::init([](const Array& nodes, const std::vector<double>& durations, const Flags& given,
                       const std::vector<int>& leg, const std::vector<PieceLimits>& limits,
                       const std::array<bool, 4>& frozen, bool tied, const std::vector<bool>& timed) {
             return Problem{{nodes_from(nodes), durations}, masks_from(given), leg, limits, timed, frozen, tied};
           }),
           "nodes"_a, "durations"_a, "given"_a, "leg"_a, "limits"_a, "frozen"_a, "tied"_a,
           "timed"_a = std::vector<bool>{},
           "given (N+1, 5, 4): what is not free; leg and limits (N,) of each piece; frozen (4,): axes that stand "
           "still; timed (N,): whose time is given.")
      .def("split", &Problem::split, "parts"_a, "Each piece cut into equal ones; the path does not change.")
      .def(
          "stretched",
          [](const Problem& problem, double factor) {
            Problem slower = problem;
            slower.start = problem.start.stretched(factor);
            return slower;
          },
          "factor"_a)
      .def("part", &Problem::part, "first"_a, "last"_a, "Pieces first..last-1 between nodes that are given whole.")
      .def(
          "with_part",
          [](const Problem& problem, int first, const Problem& part) { return problem.with(first, part.start); },
          "first"_a, "part"_a, "With the flight of a part whose first piece is `first` here.")
      .def_readwrite("tied", &Problem::tied, "Whether the pieces of a leg keep their shares of its time.")
      .def_property_readonly("nodes", [](const Problem& p) { return nodes_to(p.start.nodes); })
      .def_property_readonly("durations", [](const Problem& p) { return p.start.durations; })
      .def_property_readonly(
          "coefficients", [](const Problem& p) { return coefficients_of(p.start); }, "(N, 10, 4)")
      .def_property_readonly("leg", [](const Problem& p) { return p.leg; })
      .def_property_readonly("limits", [](const Problem& p) { return p.limits; })
      .def_property_readonly("total", [](const Problem& p) { return p.start.total(); })
      .def(
          "least_margin",
          [](const Problem& p, const Constraints& c, int samples) { return least_margin(p.start, p, c, samples); },
          "constraints"_a, "samples"_a, "Relative, the most negative of all limits; samples of each piece.");
}

void bind_solver(py::module_& m) {
  py::class_<Certificate>(m, "Certificate",
                          "Whether all limits hold at every time, and where that could not be proven.")
      .def_readonly("proven", &Certificate::proven)
      .def_readonly("unproven", &Certificate::unproven)
      .def_readonly("piece", &Certificate::piece)
      .def_readonly("bound", &Certificate::bound)
      .def_readonly("excess", &Certificate::excess)
      .def_readonly("intervals", &Certificate::intervals);

  m.def(
      "minimise_time",
      [](const Problem& problem, const Constraints& constraints, int samples, double gap_start, double gap_end,
         double gap_factor, double negligible, int iterations, double duration_min, double shift, double curvature,
         bool elastic, double spare, const Progress& progress) {
        SolverSettings settings;
        settings.samples = samples;
        settings.gap_start = gap_start;
        settings.gap_end = gap_end;
        settings.gap_factor = gap_factor;
        settings.negligible = negligible;
        settings.iterations = iterations;
        settings.duration_min = duration_min;
        settings.shift = shift;
        settings.curvature = curvature;
        settings.elastic = elastic;
        settings.spare = spare;
        Solution solution = minimise_time(problem, constraints, settings, progress);
        Problem improved = problem;
        improved.start = std::move(solution.trajectory);
        return py::make_tuple(improved, solution.feasible, solution.interrupted, solution.push_price);
      },
      "problem"_a, "constraints"_a, py::kw_only(), "samples"_a, "gap_start"_a, "gap_end"_a, "gap_factor"_a,
      "negligible"_a, "iterations"_a, "duration_min"_a, "shift"_a, "curvature"_a, "elastic"_a, "spare"_a, "progress"_a,
      "(problem with the better trajectory, feasible at its samples, interrupted, what a newton less of the "
      "least rotor thrust would save, to first order [s/N])");

  m.def(
      "rotor_range",
      [](const Problem& problem, const Constraints& constraints, int samples) {
        const RotorRange range = rotor_range(problem.start, constraints, samples);
        return py::make_tuple(py::cast(range.low), py::cast(range.high));
      },
      "problem"_a, "constraints"_a, "samples"_a, "Smallest and largest thrust of each rotor [N].");

  m.def(
      "bound_name",
      [](const Constraints& constraints, int bound) {
        return describe(constraints.rows().at(constraints.bounds().at(bound).row));
      },
      "constraints"_a, "bound"_a, "What a bound limits, in words, and its unit.");

  m.def(
      "bound_limit",
      [](const Constraints& constraints, int bound, const PieceLimits& piece) {
        return constraints.on_piece(bound, piece).limit;
      },
      "constraints"_a, "bound"_a, "piece"_a, "What a bound allows on a piece.");

  m.def(
      "certify",
      [](const Array& coefficients, const std::vector<double>& durations, const std::vector<PieceLimits>& limits,
         const Constraints& constraints) { return certify(pieces_from(coefficients), durations, limits, constraints); },
      "coefficients"_a, "durations"_a, "limits"_a, "constraints"_a,
      "Proof over whole pieces (N, 10, 4), lowest power of tau first.");
  m.def(
      "certify_planar",
      [](const Array& coefficients, const std::vector<double>& durations, const std::vector<double>& signs,
         const std::vector<double>& speed_max, const Vehicle& vehicle, const Limits& limits) {
        const std::vector<Coefficients> paths = pieces_from(coefficients);
        std::vector<PlanarPiece> pieces;
        for (std::size_t k = 0; k < paths.size(); ++k) {
          const bool begins = k > 0 && signs[k] != signs[k - 1];
          const bool ends = k + 1 < paths.size() && signs[k] != signs[k + 1];
          pieces.push_back({paths[k], durations[k], signs[k], begins, ends, speed_max[k]});
        }
        return certify_planar(pieces, vehicle, limits);
      },
      "coefficients"_a, "durations"_a, "signs"_a, "speed_max"_a, "vehicle"_a, "limits"_a,
      "Proof of flight that turns over in the x-z plane: pieces (N, 10, 4), the sign of the thrust and the speed limit "
      "of each.");
}

}  // namespace

PYBIND11_MODULE(_planner, m) {
  m.doc() = "The planner's kernel: least time inside the limits, repair between samples, and the proof.";
  bind_values(m);
  bind_problem(m);
  bind_solver(m);
  bind_closed_form(m);
}
