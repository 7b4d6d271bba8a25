// The tables behind docs/mavlink.md, for the generator: what the link says and obeys, as the firmware itself has it.
#include <pybind11/typing.h>

#include "bindings.hpp"
#include "core/failsafes.hpp"
#include "core/modes.hpp"
#include "link/codec.hpp"
#include "link/commands.hpp"
#include "link/mission_items.hpp"
#include "link/streams.hpp"

namespace halfroll::bindings {
namespace {

using Strings = std::vector<std::string>;
using Rows = py::typing::List<py::typing::Dict<py::str, py::object>>;

Strings modes_in(Bits bits) {
  Strings names;
  for (int i = 0; i < kModeCount; ++i) {
    if ((bits & bit(static_cast<Mode>(i))) != 0) names.emplace_back(mode_name(static_cast<Mode>(i)));
  }
  return names;
}

Rows mode_rules() {
  Rows rows;
  for (const ModeRule& rule : kModeRules) {
    const bool user = (rule.who & bit(Requester::kUser)) != 0,
               ground = (rule.who & bit(Requester::kGroundStation)) != 0;
    rows.append(py::dict("who"_a = user && ground ? "anybody"
                                   : user         ? "users"
                                                  : "component 191",
                         "from"_a = modes_in(rule.from), "to"_a = modes_in(rule.to), "when"_a = rule.when,
                         "why"_a = rule.why));
  }
  return rows;
}

Rows modes() {
  Rows rows;
  for (const link::WireModeRow& row : link::kWireModes) {
    rows.append(py::dict("name"_a = row.name, "custom_mode"_a = row.custom_mode, "standard_mode"_a = row.standard_mode,
                         "properties"_a = row.properties));
  }
  return rows;
}

Rows failsafes() {
  Rows rows;
  for (const FailsafeRow& row : kFailsafes) {
    rows.append(py::dict("words"_a = row.words, "condition"_a = row.condition, "action"_a = row.action_in_words,
                         "recovery"_a = row.recovery));
  }
  return rows;
}

Rows streams() {
  Rows rows;
  for (const link::StreamRow& row : link::kStreams) {
    rows.append(py::dict("id"_a = row.id, "rates_hz"_a = row.rate_hz));
  }
  return rows;
}

Rows mission_items() {
  Rows rows;
  for (std::uint32_t command = 0; command <= 0xFFFF; ++command) {
    const auto rules = link::parameter_rules(static_cast<std::uint16_t>(command));
    if (!rules) continue;
    py::list params;
    for (const link::ParameterRule& p : *rules) params.append(py::make_tuple(p.least, p.most, p.open, p.step));
    link::MissionItem item;
    item.command = static_cast<std::uint16_t>(command);
    rows.append(py::dict("command"_a = command, "params"_a = params,
                         "skipped"_a = link::flight_item(item, {}).kind == ItemKind::kSkip));
  }
  return rows;
}

/// Whether the frame says anything to the autopilot.
bool understands(const py::bytes& frame) {
  const std::string bytes = frame;
  bool understood = false;
  link::Parser parser;
  parser.parse({{0, 0}, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
               [&](const link::Received& r) { understood = !std::holds_alternative<link::Unhandled>(r.message); });
  return understood;
}

}  // namespace

void bind_contract(py::module_& m) {
  m.def("mode_rule_table", &mode_rules,
        "Why a change of mode is refused: who, from, to, when, why; first match counts.");
  m.def("mode_table", &modes, "Modes as the wire numbers them.");
  m.def("failsafe_table", &failsafes, "words, condition, action, recovery.");
  m.def("stream_table", &streams, "Message ids and their rates on each link.");
  m.def("mission_item_table", &mission_items,
        "Commands a mission may hold; params as (least, most, NaN allowed, step).");
  m.def("understands", &understands, "frame"_a, "Whether this MAVLink frame says anything to the autopilot.");
}

}  // namespace halfroll::bindings
