// The closed form and rotor thrusts with their slopes for Python, part of halfroll._planner.
#include "kernel/closed_form.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>

#include "kernel/rotor_slopes.hpp"

namespace {

namespace py = pybind11;
using namespace pybind11::literals;
using namespace halfroll::planner;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
constexpr py::ssize_t kFlat = 12;  // entries of the flat outputs that thrust depends on
using RowMajorNode = Eigen::Matrix<double, kGiven, kAxes, Eigen::RowMajor>;

std::vector<Node> nodes_from(const Array& array) {
  std::vector<Node> nodes(array.shape(0));
  const double* from = array.data();
  for (Node& node : nodes) {
    node = Eigen::Map<const RowMajorNode>(from);
    from += kGiven * kAxes;
  }
  return nodes;
}

Array nodes_to(const std::vector<Node>& nodes) {
  Array array({static_cast<py::ssize_t>(nodes.size()), py::ssize_t{kGiven}, py::ssize_t{kAxes}});
  double* to = array.mutable_data();
  for (const Node& node : nodes) {
    Eigen::Map<RowMajorNode>{to} = node;
    to += kGiven * kAxes;
  }
  return array;
}

double* write(const ClosedForm& form, double* to) {
  for (int k = 0; k < form.pieces(); ++k, to += kOrder * kAxes) Eigen::Map<Coefficients>{to} = form.coefficients(k);
  return to;
}

void require(bool holds, const char* why) {
  if (!holds) throw py::value_error(why);
}

}  // namespace

void bind_closed_form(py::module_& m) {
  py::class_<ClosedForm>(m, "ClosedForm", "The path through nodes in given times, and its exact slopes.   Eqs 23-24")
      .def(py::init([](const Array& nodes, const Array& durations, int continuity) {
             require(nodes.ndim() == 3 && nodes.shape(1) == kGiven && nodes.shape(2) == kAxes && nodes.shape(0) >= 2,
                     "nodes are (n, 5, 4), n >= 2");
             require(durations.ndim() == 1 && durations.shape(0) + 1 == nodes.shape(0), "one duration between nodes");
             require(continuity >= kGiven - 1 && continuity <= 8, "continuity is 4..8");
             return ClosedForm(nodes_from(nodes), {durations.data(), durations.data() + durations.size()}, continuity);
           }),
           "nodes"_a, "durations"_a, "continuity"_a = 8, "nodes (n, 5, 4): NaN where free; durations (n-1,) > 0.")
      .def_property_readonly("solved", &ClosedForm::solved)
      .def_property_readonly("stuck", &ClosedForm::stuck, "About which node what is given determines no path.")
      .def_property_readonly("durations",
                             [](const ClosedForm& form) { return Array(form.pieces(), form.durations().data()); })
      .def_property_readonly(
          "nodes", [](const ClosedForm& form) { return nodes_to(form.nodes()); }, "(n, 5, 4), all derivatives")
      .def_property_readonly(
          "coefficients",
          [](const ClosedForm& form) {
            Array array({py::ssize_t{form.pieces()}, py::ssize_t{kOrder}, py::ssize_t{kAxes}});
            write(form, array.mutable_data());
            return array;
          },
          "(n-1, 10, 4), lowest power of tau first")
      .def_property_readonly("bytes", &ClosedForm::bytes, "Of the eliminated equations.")
      .def(
          "slopes",
          [](const ClosedForm& form, const Array& cost) {
            require(
                cost.ndim() == 3 && cost.shape(0) == form.pieces() && cost.shape(1) == kOrder && cost.shape(2) == kAxes,
                "the cost's slopes are (n-1, 10, 4), as coefficients");
            std::vector<Coefficients> by_coefficients(form.pieces());
            const double* from = cost.data();
            for (Coefficients& c : by_coefficients) {
              c = Eigen::Map<const Coefficients>(from);
              from += kOrder * kAxes;
            }
            const ClosedForm::Slopes slopes = form.slopes(by_coefficients);
            Array durations(form.pieces());
            std::memcpy(durations.mutable_data(), slopes.durations.data(), sizeof(double) * slopes.durations.size());
            return py::make_tuple(durations, nodes_to(slopes.given));
          },
          "cost"_a,
          "(by durations (n-1,), by given derivatives (n, 5, 4)) from slopes over coefficients (n-1, 10, 4).");

  m.def(
      "closed_forms",
      [](const Array& nodes, const Array& durations) {
        const py::ssize_t sets = durations.shape(0), pieces = durations.shape(1);
        const std::vector<Node> given = nodes_from(nodes);
        Array array({sets, pieces, py::ssize_t{kOrder}, py::ssize_t{kAxes}});
        double* to = array.mutable_data();
        for (py::ssize_t b = 0; b < sets; ++b) {
          const double* from = durations.data() + b * pieces;
          const ClosedForm form(given, {from, from + pieces}, 8);
          if (!form.solved()) return py::object(py::none());
          to = write(form, to);
        }
        return py::object(array);
      },
      "nodes"_a, "durations"_a, "Coefficients (B, n-1, 10, 4) for B sets of durations (B, n-1); None if one has none.");

  m.def(
      "rotor_slopes",
      [](const Array& flat, const Vehicle& vehicle) {
        require(flat.ndim() == 2 && flat.shape(1) == kFlat, "flat outputs are (S, 12)");
        const py::ssize_t samples = flat.shape(0);
        Array thrusts({samples, py::ssize_t{4}}), by({samples, py::ssize_t{4}, py::ssize_t{kFlat}});
        const double* from = flat.data();
        double *to = thrusts.mutable_data(), *to_slopes = by.mutable_data();
        for (py::ssize_t s = 0; s < samples; ++s, from += kFlat) {
          const RotorSlopes found = rotor_slopes({{from[0], from[1], from[2]},
                                                  {from[3], from[4], from[5]},
                                                  {from[6], from[7], from[8]},
                                                  from[9],
                                                  from[10],
                                                  from[11]},
                                                 vehicle);
          to = std::copy(found.thrusts.begin(), found.thrusts.end(), to);
          for (const FlatGradient<double>& g : found.by) {
            for (const auto& vector : {g.acceleration, g.jerk, g.snap}) {
              to_slopes = std::copy(vector.begin(), vector.end(), to_slopes);
            }
            for (const double number : {g.yaw, g.yaw_rate, g.yaw_acceleration}) *to_slopes++ = number;
          }
        }
        return py::make_tuple(thrusts, by);
      },
      "flat"_a, "vehicle"_a,
      "Rotor thrusts (S, 4) and slopes (S, 4, 12) over flat (S, 12): acceleration, jerk, snap, yaw and its two "
      "derivatives; thrust upward.");
}
