#include "run/snapshot_file.hpp"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/readable.hpp"
#include "simulation/quantity.hpp"

namespace servohil::run {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 3;  // 3: the supervision's state
constexpr int kOldestVersion = 2;
constexpr const char* kFormat = "servohil snapshot";

/// Finds damage, not malice.
std::string Checksum(const std::string& text) {
  return base::HashText(configuration::Fnv1a(text));
}

[[noreturn]] void Refuse(const char* what, const Json* json) {
  throw Json::other_error::create(500, what, json);
}

/// A snapshot's depth is 8; what is much deeper takes all of the stack.
template <typename Input>
Json ParseShallow(Input&& input) {
  constexpr int kDeepest = 32;
  return Json::parse(input, [](int depth, Json::parse_event_t, const Json&) {
    if (depth > kDeepest) Refuse("nested too deep", nullptr);
    return true;
  });
}

/// Numbers as they are: whole ones must fit.
template <typename T>
void Take(const Json& json, T& value) {
  if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
    const bool fits = json.is_number_unsigned()
                          ? std::in_range<T>(json.get<std::uint64_t>())
                          : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
    if (!fits) Refuse("range", &json);
  }
  json.get_to(value);
}

template <typename Enum>
Enum EnumOf(const Json& value, Enum last) {
  int number = 0;
  Take(value, number);
  if (number < 0 || number > static_cast<int>(last)) Refuse("range", &value);
  return static_cast<Enum>(number);
}

// JSON has no numbers for what is not available or beyond all scales.
Json Number(double value) {
  return std::isnan(value) ? Json("nan") : std::isinf(value) ? Json(value > 0 ? "inf" : "-inf") : Json(value);
}
double NumberFrom(const Json& value) {
  if (value.is_number()) return value.get<double>();
  return value == "nan" ? std::nan("") : value == "inf" ? HUGE_VAL : -HUGE_VAL;
}

Json ToJson(const fault::Trigger& trigger) {
  return {{"kind", static_cast<int>(trigger.kind)},
          {"quantity", trigger.quantity},
          {"above", trigger.above},
          {"threshold", trigger.threshold},
          {"frame_id", trigger.frame_id},
          {"extended", trigger.extended},
          {"fault", trigger.fault}};
}

fault::Trigger TriggerFromJson(const Json& json) {
  fault::Trigger trigger;
  trigger.kind = EnumOf(json.at("kind"), fault::Trigger::Kind::kFault);
  Take(json.at("quantity"), trigger.quantity);
  Take(json.at("above"), trigger.above);
  Take(json.at("threshold"), trigger.threshold);
  Take(json.at("frame_id"), trigger.frame_id);
  Take(json.at("extended"), trigger.extended);
  Take(json.at("fault"), trigger.fault);
  return trigger;
}

/// Of this program's catalogue and quantities.
bool IsSound(const fault::Injection& i) {
  const fault::Spec* spec = fault::Find(i.id);
  const bool waits_for_fault = i.trigger.kind == fault::Trigger::Kind::kFault;
  return spec != nullptr && (!spec->HasSignal() || i.target < simulation::Quantities().size()) &&
         i.trigger.quantity < simulation::Quantities().size() &&
         (!waits_for_fault || fault::Find(i.trigger.fault) != nullptr);
}

Json ToJson(const fault::Schedule& faults) {
  Json list = Json::array();
  for (const fault::Injection& i : faults) {
    list.push_back({{"fault", i.id},
                    {"target", i.target},
                    {"values", i.values},
                    {"seed", i.seed},
                    {"start_tick", i.start_tick},
                    {"ramp_ticks", i.ramp_ticks},
                    {"ramp_out_ticks", i.ramp_out_ticks},
                    {"for_ticks", i.for_ticks},
                    {"period_ticks", i.period_ticks},
                    {"times", i.times},
                    {"trigger", ToJson(i.trigger)},
                    {"waits", i.waits},
                    {"was_true", i.was_true},
                    {"fired", i.fired},
                    {"held", Number(i.held)}});
  }
  return list;
}

fault::Schedule ScheduleFromJson(const Json& list) {
  fault::Schedule faults;
  for (const Json& one : list) {
    fault::Injection i;
    Take(one.at("fault"), i.id);
    Take(one.at("values"), i.values);
    Take(one.at("start_tick"), i.start_tick);
    Take(one.at("ramp_ticks"), i.ramp_ticks);
    Take(one.at("target"), i.target);
    Take(one.at("seed"), i.seed);
    Take(one.at("ramp_out_ticks"), i.ramp_out_ticks);
    Take(one.at("for_ticks"), i.for_ticks);
    Take(one.at("period_ticks"), i.period_ticks);
    Take(one.at("times"), i.times);
    i.trigger = TriggerFromJson(one.at("trigger"));
    Take(one.at("waits"), i.waits);
    Take(one.at("was_true"), i.was_true);
    Take(one.at("fired"), i.fired);
    i.held = NumberFrom(one.at("held"));
    if (!IsSound(i) || !faults.Inject(i)) Refuse("fault", &one);
  }
  faults.ForgetEvents();
  return faults;
}

Json ToJson(const simulation::CommandMonitorState& s) {
  return {{"state", static_cast<int>(s.state)},
          {"cause", static_cast<int>(s.cause)},
          {"governed", s.governed},
          {"silent_ticks", s.silent_ticks},
          {"losses", s.losses},
          {"trips", s.trips}};
}

Json ToJson(const emulator::Snapshot& snapshot) {
  const simulation::Sample& sample = snapshot.sample;
  const model::State& s = sample.state;
  return {{"tick", sample.tick},
          {"p1_psi", sample.p1_psi},
          {"x3_in", s.x3_in},
          {"v3_in_s", s.v3_in_s},
          {"p3_psi", s.p3_psi},
          {"p4_psi", s.p4_psi},
          {"p8_psi", s.p8_psi},
          {"p2_psi", s.p2_psi},
          {"motion", static_cast<int>(s.mode.motion)},
          {"plunger", static_cast<int>(s.mode.plunger)},
          {"diaphragm_seated", s.mode.diaphragm_seated},
          {"relay_port_full", s.mode.relay_port_full},
          {"unresolved_ticks", sample.unresolved_ticks},
          {"sub_steps", sample.sub_steps},
          {"model_fault", sample.model_fault},
          {"state_hash", sample.state_hash},
          {"commanded", snapshot.commanded},
          {"command_p1_psi", snapshot.safety.demand_psi},
          {"command_tick", snapshot.command_tick},
          {"safety", ToJson(snapshot.safety)},
          {"faults", ToJson(snapshot.faults)}};
}

/// @param json  of a snapshot; before version 3 a command was followed for ever
simulation::CommandMonitorState CommandMonitorFromJson(const Json& json, const emulator::Snapshot& snapshot) {
  simulation::CommandMonitorState s;
  Take(json.at("command_p1_psi"), s.demand_psi);
  if (!json.contains("safety")) {
    s.state = snapshot.sample.model_fault ? simulation::SafetyState::kFaulted
              : snapshot.commanded        ? simulation::SafetyState::kRunning
                                          : simulation::SafetyState::kWaiting;
    return s;
  }
  const Json& safety = json.at("safety");
  s.state = EnumOf(safety.at("state"), simulation::SafetyState::kFaulted);
  s.cause = EnumOf(safety.at("cause"), simulation::SafetyCause::kModelFault);
  Take(safety.at("governed"), s.governed);
  Take(safety.at("silent_ticks"), s.silent_ticks);
  Take(safety.at("losses"), s.losses);
  Take(safety.at("trips"), s.trips);
  return s;
}

emulator::Snapshot FromJson(const Json& json) {
  emulator::Snapshot snapshot;
  simulation::Sample& sample = snapshot.sample;
  model::State& s = sample.state;
  Take(json.at("tick"), sample.tick);
  Take(json.at("p1_psi"), sample.p1_psi);
  Take(json.at("x3_in"), s.x3_in);
  Take(json.at("v3_in_s"), s.v3_in_s);
  Take(json.at("p3_psi"), s.p3_psi);
  Take(json.at("p4_psi"), s.p4_psi);
  Take(json.at("p8_psi"), s.p8_psi);
  Take(json.at("p2_psi"), s.p2_psi);
  s.mode.motion = EnumOf(json.at("motion"), model::Motion::kAtUpperStop);
  s.mode.plunger = EnumOf(json.at("plunger"), model::Plunger::kAtUpperStop);
  Take(json.at("diaphragm_seated"), s.mode.diaphragm_seated);
  Take(json.at("relay_port_full"), s.mode.relay_port_full);
  Take(json.at("unresolved_ticks"), sample.unresolved_ticks);
  Take(json.at("sub_steps"), sample.sub_steps);
  Take(json.at("model_fault"), sample.model_fault);
  Take(json.at("state_hash"), sample.state_hash);
  Take(json.at("commanded"), snapshot.commanded);
  Take(json.at("command_tick"), snapshot.command_tick);
  snapshot.safety = CommandMonitorFromJson(json, snapshot);
  snapshot.faults = ScheduleFromJson(json.at("faults"));
  return snapshot;
}

Json ToJson(const configuration::RunTexts& texts) {
  return {{"configuration", texts.configuration_toml},
          {"load", texts.load_csv},
          {"load_closing", texts.load_closing_csv},
          {"dbc", texts.dbc}};
}

configuration::RunTexts TextsFromJson(const Json& json) {
  configuration::RunTexts texts;
  Take(json.at("configuration"), texts.configuration_toml);
  Take(json.at("load"), texts.load_csv);
  Take(json.at("load_closing"), texts.load_closing_csv);
  const Json& dbc = json.at("dbc");
  texts.dbc = dbc.is_string() ? std::vector<std::string>{dbc} : dbc.get<std::vector<std::string>>();
  return texts;
}

/// What the checksum is of. Not UTF-8 (a DBC may be Latin-1): replaced alike when written and when read.
std::string ContentText(const Json& content) {
  return content.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string SnapshotText(const emulator::Snapshot& snapshot) {
  return ToJson(snapshot).dump();
}

emulator::Snapshot ParseSnapshotText(const std::string& text, const std::string& place) {
  try {
    return FromJson(ParseShallow(text));
  } catch (const Json::exception& error) {
    throw base::UsageError(place + ": damaged: " + error.what());
  }
}

void WriteSnapshot(const std::filesystem::path& file, const SnapshotFile& snapshot) {
  Json content = {{"program", snapshot.program_version},
                  {"state", ToJson(snapshot.snapshot)},
                  {"texts", ToJson(snapshot.texts)}};
  const Json whole = {{"format", kFormat},
                      {"version", kVersion},
                      {"checksum", Checksum(ContentText(content))},
                      {"content", std::move(content)}};
  const std::filesystem::path beside = file.string() + ".tmp";
  {
    std::ofstream out(beside);
    out << whole.dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
    out.close();
    if (!out)
      throw base::EnvironmentError(file.string() + ": cannot be written (disk full, or no permission?)");
  }
  std::error_code error;
  std::filesystem::rename(beside, file, error);
  if (error) throw base::EnvironmentError(file.string() + ": cannot be written: " + error.message());
}

SnapshotFile ReadSnapshot(const std::filesystem::path& file) {
  const std::string name = file.string();
  base::RequireReadable(file);
  std::ifstream in(file);
  Json whole;
  try {
    whole = ParseShallow(in);
  } catch (const Json::exception& error) {
    throw base::UsageError(name + ": damaged or no snapshot: it is not JSON");
  }
  if (!whole.is_object() || whole.value("format", Json()) != kFormat)
    throw base::UsageError(name + ": no servohil snapshot (\"format\" is not \"" + kFormat + "\")");
  try {
    int version = 0;
    Take(whole.at("version"), version);
    if (version < kOldestVersion || version > kVersion) {
      throw base::UsageError(name + ": is a snapshot of version " + std::to_string(version) +
                             ", this program reads " + std::to_string(kOldestVersion) + " to " +
                             std::to_string(kVersion));
    }
    const Json& content = whole.at("content");
    if (whole.at("checksum") != Checksum(ContentText(content)))
      throw base::UsageError(name + ": damaged: its content does not have its checksum");
    return {content.at("program"), FromJson(content.at("state")), TextsFromJson(content.at("texts"))};
  } catch (const Json::exception& error) {
    throw base::UsageError(name + ": damaged: " + error.what());
  }
}

}  // namespace servohil::run
