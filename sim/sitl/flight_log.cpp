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

std::string lines(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\n";
  return text;
}

/// The file's first part, as far as it is words.
Ulog& introduce(Ulog& ulog, const FlightFacts& facts, const sim::Plant& plant, const Params& params) {
  ulog.info("sys_name", "halfroll");
  ulog.info("ver_hw", "SITL");
  ulog.info("ver_sw", facts.commit);
  ulog.info("ver_halfroll", facts.version);
  ulog.info("ver_data_format", 2);  // PX4's: latitudes are doubles
  ulog.info("time_ref_utc", 0);     // [s] that the writer's local time is ahead
  ulog.info("time_unix_us", std::to_string(facts.unix_us));
  ulog.info("vehicle", facts.vehicle);
  ulog.info("scenario", facts.scenario);
  ulog.info("seed", std::to_string(facts.seed));
  ulog.info("lockstep", facts.lockstep ? "yes" : "no");
  ulog.info("sitl_arguments", lines(facts.arguments));
  ulog.info("rotor_thrust_min_N", static_cast<float>(plant.thrust_min));
  ulog.info("rotor_thrust_max_N", static_cast<float>(plant.thrust_max));
  for (const ParamInfo& row : kParamTable) ulog.param(row.id, params.*row.member);
  ulog.param("MAV_TYPE", 2);  // quadrotor; PX4 has it among its parameters, and its tools ask for it
  return ulog;
}

}  // namespace

FlightLog::FlightLog(const std::string& path, const FlightFacts& facts, const sim::Plant& plant, const Params& params)
    : ulog_(path),
      truth_(introduce(ulog_, facts, plant, params)
                 .add_topic("vehicle_truth", "float[3] p;float[3] v;float[4] q;float[3] w;float[4] f;")),
      commands_(ulog_.add_topic("rotor_commands", "float[4] thrust;")),
      estimate_(ulog_.add_topic("vehicle_estimate", "float[3] p;float[3] v;float[4] q;float[3] w;")),
      reference_(ulog_.add_topic("attitude_reference", "float[4] q;float[3] w;float thrust;")),
      state_(ulog_.add_topic("vehicle_state", "uint8_t mode;uint8_t armed;")),
      link_(ulog_.add_topic("ground_link", "float age_s;uint32_t frames;")),
      params_(params),
      px4_(ulog_, plant, facts.origin, params.thrust_reference, static_cast<int>(params.system_id)),
      heard_(ulog_) {
  // of the ground station, which appends them: what it wanted to be flown
  ulog_.announce("trajectory_reference", "float plan_s;float[3] p;float[3] v;float[3] a;float yaw;float[4] f;");
  ulog_.announce("vehicle_local_position_setpoint",
                 "float x;float y;float z;float yaw;float vx;float vy;float vz;float[3] acceleration;");
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

  if (r.t_us % kEstimateUs == 0) {
    ulog_.begin(estimate_, r.t_us);
    put_each(ulog_, r.estimate.p_WB);
    put_each(ulog_, r.estimate.v_WB);
    put(ulog_, r.estimate.q_WB);
    put_each(ulog_, r.estimate.w_WB_B);
    ulog_.end();
  }

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

  if (r.ground_frames != ground_frames_) {
    ground_frames_ = r.ground_frames;
    ground_heard_us_ = r.t_us;
  }
  if (r.t_us % kLinkUs == 0) {
    ulog_.begin(link_, r.t_us);
    ulog_.put(1e-6F * static_cast<float>(r.t_us - ground_heard_us_));
    ulog_.put(ground_frames_);
    ulog_.end();
  }

  px4_.add(ulog_, r);
  if (r.t_us % kParamsUs == 0) add_changed_params(r.params);

  if (r.t_us - flushed_us_ >= kFlushUs) {
    ulog_.flush();
    flushed_us_ = r.t_us;
  }
}

void FlightLog::add_changed_params(const Params& params) {
  for (const ParamInfo& row : kParamTable) {
    if (params.*row.member != params_.*row.member) ulog_.param(row.id, params.*row.member);
  }
  params_ = params;
}

bool FlightLog::finish(const std::string& commands_sha256) {
  ulog_.info("commands_sha256", commands_sha256);
  ulog_.flush();
  return ulog_.good();
}

}  // namespace halfroll::sitl
