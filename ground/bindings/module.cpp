#include "bindings.hpp"

PYBIND11_MODULE(_firmware, m) {
  m.doc() = "The firmware and the simulated world, linked from the same libraries as halfroll-sitl.";
  halfroll::bindings::bind_core(m);
  halfroll::bindings::bind_estimator(m);
  halfroll::bindings::bind_world(m);
  halfroll::bindings::bind_flight(m);
  halfroll::bindings::bind_stream(m);
  halfroll::bindings::bind_board(m);
  halfroll::bindings::bind_contract(m);
}
