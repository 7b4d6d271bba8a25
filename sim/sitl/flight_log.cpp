#include "sim/sitl/flight_log.hpp"

namespace halfroll::sitl {
namespace {

template <typename Numbers>
void put_each(Ulog& ulog, const Numbers& numbers) {
  for (const auto x : numbers) ulog.put(static_cast<float>(x));
}

void put(Ulog& ulog, const Quat& q) {
  for (const float x : {q.w, q.x, q.y, q.z}) ulog.put(x);
}

}  // namespace

FlightLog::FlightLog(const std::string& path, const FlightFacts& facts, const Params& params) : ulog_(path) {
  ulog_.info("sys_name", "halfroll");
  ulog_.info("ver_sw", facts.version);
  ulog_.info("vehicle", facts.vehicle);
  ulog_.info("scenario", facts.scenario);
  ulog_.info("seed", std::to_string(facts.seed));
  ulog_.info("lockstep", facts.lockstep ? "yes" : "no");
  for (const ParamInfo& row : kParamTable) ulog_.param(row.id, params.*row.member);
  truth_ = ulog_.add_topic("vehicle_truth", "float[3] p;float[3] v;float[4] q;float[3] w;float[4] f;");
  commands_ = ulog_.add_topic("rotor_commands", "float[4] thrust;");
  estimate_ = ulog_.add_topic("vehicle_estimate", "float[3] p;float[3] v;float[4] q;float[3] w;");
  reference_ = ulog_.add_topic("attitude_reference", "float[4] q;float[3] w;float thrust;");
  state_ = ulog_.add_topic("vehicle_state", "uint8_t mode;uint8_t armed;");
  ulog_.begin_data();
}

void FlightLog::add(const FlightRecord& r) {
  const sim::RigidBody& body = r.truth.body;
  ulog_.begin(truth_, r.t_us);
  put_each(ulog_, body.p_WB);
  put_each(ulog_, body.v_WB);
  put_each(ulog_, body.q_WB);
  put_each(ulog_, body.w_WB_B);
  put_each(ulog_, r.truth.rotors.thrust);
  ulog_.end();

  ulog_.begin(commands_, r.t_us);
  put_each(ulog_, r.commands.thrust);
  ulog_.end();

  ulog_.begin(estimate_, r.t_us);
  put_each(ulog_, r.estimate.p_WB);
  put_each(ulog_, r.estimate.v_WB);
  put(ulog_, r.estimate.q_WB);
  put_each(ulog_, r.estimate.w_WB_B);
  ulog_.end();

  ulog_.begin(reference_, r.t_us);
  put(ulog_, r.reference.q_WD);
  put_each(ulog_, r.reference.w_WD_D);
  ulog_.put(r.reference.thrust);
  ulog_.end();

  const int armed = r.armed ? 1 : 0;
  if (r.mode != last_mode_ || armed != last_armed_ || r.t_us % kReferenceUs == 0) {
    ulog_.begin(state_, r.t_us);
    ulog_.put(r.mode);
    ulog_.put(static_cast<std::uint8_t>(armed));
    ulog_.end();
    last_mode_ = r.mode;
    last_armed_ = armed;
  }

  if (r.t_us - flushed_us_ >= kFlushUs) {
    ulog_.flush();
    flushed_us_ = r.t_us;
  }
}

bool FlightLog::finish(const std::string& commands_sha256) {
  ulog_.info("commands_sha256", commands_sha256);
  ulog_.flush();
  return ulog_.good();
}

}  // namespace halfroll::sitl
