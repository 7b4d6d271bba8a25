// The ground's references, and whole flights that are streamed to, for Python.
#include <cstring>

#include "bindings.hpp"
#include "stream/references.hpp"
#include "stream/sortie.hpp"

namespace halfroll::bindings {
namespace {

using stream::Derivatives;
using stream::Ending;
using stream::Leads;
using stream::Path;
using stream::Row3;
using stream::Sortie;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

template <class Row>
std::vector<Row> rows_of(const Doubles& array) {
  std::vector<Row> rows(static_cast<std::size_t>(array.shape(0)));
  std::memcpy(rows.data(), array.data(), rows.size() * sizeof(Row));
  return rows;
}

template <class Row>
auto array_of(const std::vector<Row>& rows, std::vector<py::ssize_t> shape) {
  using Number = std::remove_cv_t<std::remove_pointer_t<decltype(rows.data()->data())>>;
  shape.insert(shape.begin(), static_cast<py::ssize_t>(rows.size()));
  py::array_t<Number> array(shape);
  std::memcpy(array.mutable_data(), rows.data(), rows.size() * sizeof(Row));
  return array;
}

py::array_t<double> derivatives_array(const std::vector<Derivatives>& rows) {
  py::array_t<double> array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{5}, py::ssize_t{4}});
  std::memcpy(array.mutable_data(), rows.data(), rows.size() * sizeof(Derivatives));
  return array;
}

Eigen::Matrix<double, 5, 4, Eigen::RowMajor> matrix_of(const Derivatives& d) {
  return Eigen::Map<const Eigen::Matrix<double, 5, 4, Eigen::RowMajor>>(d[0].data());
}

Derivatives derivatives_of(const Eigen::Matrix<double, 5, 4, Eigen::RowMajor>& matrix) {
  Derivatives d;
  std::memcpy(d.data(), matrix.data(), sizeof d);
  return d;
}

Eigen::Vector3d vector_of(const Row3& row) { return {row[0], row[1], row[2]}; }

std::shared_ptr<Path> make_path(const Doubles& derivatives, const Doubles& rates, std::vector<double> sigma_events,
                                bool leads_nose, std::vector<std::pair<double, double>> turns) {
  if (derivatives.ndim() != 3 || derivatives.shape(1) != 5 || derivatives.shape(2) != 4) {
    throw py::value_error("derivatives must have shape (N, 5, 4)");
  }
  if (rates.ndim() != 2 || rates.shape(1) != 3) throw py::value_error("rates must have shape (N, 3)");
  return std::make_shared<Path>(rows_of<Derivatives>(derivatives), rows_of<Row3>(rates), std::move(sigma_events),
                                leads_nose, std::move(turns));
}

void bind_path(py::module_& m) {
  py::class_<Path, std::shared_ptr<Path>>(
      m, "Path",
      "A path as a table over its own time, 1 ms apart; before its start and after its end it is at rest. derivatives "
      "(N, 5, 4): position to snap of x, y, z [m] in W and yaw [rad]; rates (N, 3): body rates [rad/s] that its exact "
      "inverse dynamics need, body components; sigma_events: when the thrust turns over, upright before the first; "
      "leads_nose: feedback turns its attitude the shortest way, but not in its turns (begin, end) nor upside down.")
      .def(py::init(&make_path), "derivatives"_a, "rates"_a, "sigma_events"_a = std::vector<double>{},
           "leads_nose"_a = false, "turns"_a = std::vector<std::pair<double, double>>{})
      .def_property_readonly("derivatives", [](const Path& p) { return derivatives_array(p.derivatives()); })
      .def_property_readonly("rates", [](const Path& p) { return array_of(p.rates(), {3}); })
      .def_property_readonly("sigma_events", &Path::sigma_events)
      .def_property_readonly("leads_nose", &Path::leads_nose)
      .def_property_readonly("turns", &Path::turns)
      .def_property_readonly("duration", &Path::duration)
      .def(
          "at", [](const Path& p, double t) { return matrix_of(p.at(t)); }, "t"_a, "(5, 4), linear between table rows.")
      .def(
          "rate_at", [](const Path& p, double t) { return vector_of(p.rate_at(t)); }, "t"_a)
      .def(
          "rate_change_at", [](const Path& p, double t) { return vector_of(p.rate_change_at(t)); }, "t"_a)
      .def("sigma_at", &Path::sigma_at, "t"_a)
      .def("leads_nose_at", &Path::leads_nose_at, "t"_a)
      .def("is_near_sigma_event", &Path::is_near_sigma_event, "t"_a)
      .def(py::pickle(
          [](const Path& p) -> py::object {
            return py::make_tuple(derivatives_array(p.derivatives()), array_of(p.rates(), {3}), p.sigma_events(),
                                  p.leads_nose(), p.turns());
          },
          [](const py::object& pickled) {
            const py::tuple state = pickled;
            return make_path(state[0].cast<Doubles>(), state[1].cast<Doubles>(), state[2].cast<std::vector<double>>(),
                             state[3].cast<bool>(), state[4].cast<std::vector<std::pair<double, double>>>());
          }));
}

/// Anything with the fields of a telemetry sample.
Estimate estimate_of(const py::object& state) {
  Estimate estimate;
  estimate.q_WB = to_quat(state.attr("q_WB").cast<Quad>());
  estimate.w_WB_B = state.attr("w_WB_B").cast<Vec3>();
  estimate.p_WB = state.attr("p_WB").cast<Vec3>();
  estimate.v_WB = state.attr("v_WB").cast<Vec3>();
  estimate.attitude_valid = estimate.position_valid = true;
  return estimate;
}

void bind_references(py::module_& m) {
  py::class_<Leads>(m, "Leads",
                    "How far ahead of the tick each field of a setpoint is taken [s]; the attitude at the tick itself.")
      .def_static("of", &Leads::of, "params"_a, "link_delay"_a, "rotor_delay"_a = 0.0,
                  "params: the autopilot's; link_delay: what the wire is believed to take [s], 0 in lockstep.")
      .def_readonly("mid_age", &Leads::mid_age)
      .def_readonly("rate_gain", &Leads::rate_gain)
      .def_readonly("delay", &Leads::delay)
      .def_readonly("lag", &Leads::lag)
      .def("acceleration", &Leads::acceleration, "path"_a, "t"_a,
           "What the rotors are asked for so that, lagging, they give the path's acceleration.")
      .def("rate_ahead", &Leads::rate_ahead, "path"_a, "t"_a, "What the rate sent at t is more than the path's at t.");
  m.def(
      "nose_led",
      [](const Eigen::Matrix<double, 5, 4, Eigen::RowMajor>& planned, double rate, const Quad& q_WD,
         const Vec3& w_WD_D) {
        Setpoint tried;
        tried.q_WD = to_quat(q_WD);
        tried.w_WD_D = w_WD_D;
        return matrix_of(stream::nose_led(derivatives_of(planned), rate, tried));
      },
      "planned"_a, "rate"_a, "q_WD"_a, "w_WD_D"_a,
      "(5, 4) with the yaw and yaw rate that turn the planned attitude the shortest way to the thrust axis of q_WD.");
  py::class_<stream::References>(m, "References", "One setpoint a tick along a path, by the bound outer loop.")
      .def(py::init<const Vehicle&, const Params&, const Leads&>(), "vehicle"_a, "params"_a, "leads"_a)
      .def(
          "begin",
          [](stream::References& r, const py::object& state) { r.begin(to_quat(state.attr("q_WB").cast<Quad>())); },
          "state"_a, "Forget what was flown before; continue from this attitude.")
      .def(
          "setpoint",
          [](stream::References& r, const Path& path, std::uint64_t start_us, const py::object& state) {
            return r.setpoint(path, start_us, state.attr("t_us").cast<std::uint64_t>(), estimate_of(state));
          },
          "path"_a, "start_us"_a, "state"_a,
          "What to send at the tick of `state` (t_us, q_WB, w_WB_B, p_WB, v_WB) when `path` began at start_us of "
          "vehicle "
          "time.");
}

stream::Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

using OriginNumbers = std::array<std::int32_t, 3>;

std::unique_ptr<Sortie> make_sortie(const Vehicle& vehicle, const Params& params, const sim::Plant& plant,
                                    const sim::Scenario& scenario, std::uint64_t seed, const OriginNumbers& origin,
                                    const py::bytes& mission) {
  return std::make_unique<Sortie>(vehicle, params, plant, scenario, seed, link::Origin(origin[0], origin[1], origin[2]),
                                  bytes_of(mission));
}

py::bytes python_bytes(const stream::Bytes& b) { return {reinterpret_cast<const char*>(b.data()), b.size()}; }

Ending follow(Sortie& sortie, const stream::References& references, const std::shared_ptr<Path>& approach,
              const std::shared_ptr<Path>& plan, double duration, const Eigen::Vector3d& start,
              const py::bytes& take_over, double hold_s, double delay_s, double jitter_s, double loss) {
  const stream::Task task{approach, plan, duration, hold_s, start};
  const stream::Bytes command = bytes_of(take_over);
  py::gil_scoped_release release;
  return sortie.follow(task, references, command, {delay_s, jitter_s, loss});
}

void bind_sortie(py::module_& m) {
  py::enum_<Ending>(m, "Ending", "How the flight of a plan ended.")
      .value("FLOWN", Ending::kFlown)
      .value("DID_NOT_START", Ending::kDidNotStart)
      .value("NEVER_SETTLED", Ending::kNeverSettled)
      .value("LEFT_PLAN", Ending::kLeftPlan)
      .value("RELEASED", Ending::kReleased)
      .value("CRASHED", Ending::kCrashed);
  py::class_<Sortie>(m, "Sortie",
                     "One flight inside this process, from switch-on to the end of a plan: autopilot, world, and the "
                     "ground's references at 100 Hz through MAVLink bytes over a modelled link.")
      .def(py::init(&make_sortie), "vehicle"_a, "params"_a, "plant"_a, "scenario"_a, "seed"_a, "origin"_a,
           "mission"_a = py::bytes(""), "origin: lat_degE7, lon_degE7, alt_mm; mission: as stored_mission.")
      .def(
          "service",
          [](Sortie& s, const py::bytes& rx, int link) {
            std::vector<py::bytes> sent;
            for (const stream::Bytes& frame : s.service(bytes_of(rx), link)) sent.push_back(python_bytes(frame));
            return sent;
          },
          "rx"_a, "link"_a, "Answer a link while no time passes; frames of that link.")
      .def_property_readonly("stored_mission", [](const Sortie& s) { return python_bytes(s.stored_mission()); })
      .def(
          "take_off",
          [](Sortie& s, const std::vector<py::bytes>& commands, int first_item, double patience_s) {
            std::vector<stream::Bytes> frames;
            for (const py::bytes& command : commands) frames.push_back(bytes_of(command));
            py::gil_scoped_release release;
            return s.take_off(frames, first_item, patience_s);
          },
          "commands"_a, "first_item"_a, "patience_s"_a,
          "Send the commands as soon as home is known, and fly until that mission item is reached; False if it is not.")
      .def(
          "follow", &follow, "references"_a, "approach"_a, "plan"_a, "duration"_a, "start"_a, "take_over"_a,
          "hold_s"_a = 0.0, "delay_s"_a = 0.0, "jitter_s"_a = 0.0, "loss"_a = 0.0,
          "From now, at a tick: take over, fly the approach to `start`, the plan, and hover at its end for hold_s. The "
          "link delays every frame by delay_s and up to jitter_s more, and loses a share of them.")
      .def_property_readonly("t_us", &Sortie::t_us)
      .def_property_readonly("params", [](const Sortie& s) { return s.autopilot().params(); })
      .def_property_readonly("armed", [](const Sortie& s) { return s.autopilot().armed(); })
      .def_property_readonly("crashed", [](const Sortie& s) { return s.world().contact.crashed; })
      .def_property_readonly("estimate", [](const Sortie& s) { return s.autopilot().estimate(); })
      .def_property_readonly("p_WB", [](const Sortie& s) { return s.world().body.p_WB; })
      .def_property_readonly("q_WB", [](const Sortie& s) { return s.world().body.q_WB; })
      .def_property_readonly("plan_start_us", &Sortie::plan_start_us, "0 if the plan was not begun.")
      .def_property_readonly("plan_end_us", &Sortie::plan_end_us, "The tick at or after its end; 0 if not reached.")
      .def_property_readonly(
          "positions", [](const Sortie& s) { return array_of(s.positions(), {3}); },
          "(N, 3) true position each millisecond from 0 [m], when the commands were given.")
      .def_property_readonly(
          "commands", [](const Sortie& s) { return array_of(s.commands(), {4}); },
          "(N, 4) rotor commands each millisecond from 0 [N].");
}

}  // namespace

void bind_stream(py::module_& m) {
  bind_path(m);
  bind_references(m);
  bind_sortie(m);
}

}  // namespace halfroll::bindings
