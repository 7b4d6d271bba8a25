// Conversions every binding file shares. Why: Python sees arrays and keywords, C++ sees its own types; nothing is
// computed.
#pragma once
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "core/types.hpp"

namespace halfroll::bindings {

namespace py = pybind11;
using namespace pybind11::literals;

/// A quaternion as Python has it: four floats [w, x, y, z].
using Quad = Eigen::Vector4f;

inline Quat to_quat(const Quad& q) { return {q[0], q[1], q[2], q[3]}; }
inline Quad from_quat(const Quat& q) { return {q.w, q.x, q.y, q.z}; }

void bind_board(py::module_& m);
void bind_contract(py::module_& m);
void bind_core(py::module_& m);
void bind_estimator(py::module_& m);
void bind_flight(py::module_& m);
void bind_stream(py::module_& m);
void bind_world(py::module_& m);

}  // namespace halfroll::bindings
