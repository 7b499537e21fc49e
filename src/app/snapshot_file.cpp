#include "snapshot_file.hpp"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formatted.hpp"
#include "servohil/app/quantity.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 3;  // 3: the supervision's state
constexpr int kOldestVersion = 2;
constexpr const char* kFormat = "servohil snapshot";

/// Finds damage, not malice.
std::string Checksum(const std::string& text) {
  return HashText(Fnv1a(text));
}

template <typename Enum>
Enum EnumOf(const Json& value, Enum last) {
  const int number = value.get<int>();
  if (number < 0 || number > static_cast<int>(last)) throw Json::other_error::create(500, "range", &value);
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
  json.at("quantity").get_to(trigger.quantity);
  json.at("above").get_to(trigger.above);
  json.at("threshold").get_to(trigger.threshold);
  json.at("frame_id").get_to(trigger.frame_id);
  json.at("extended").get_to(trigger.extended);
  json.at("fault").get_to(trigger.fault);
  return trigger;
}

/// Of this program's catalogue and quantities.
bool IsSound(const fault::Injection& i) {
  const fault::Spec* spec = fault::Find(i.id);
  return spec != nullptr && (!spec->HasSignal() || i.target < Quantities().size()) &&
         i.trigger.quantity < Quantities().size();
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
    one.at("fault").get_to(i.id);
    one.at("values").get_to(i.values);
    one.at("start_tick").get_to(i.start_tick);
    one.at("ramp_ticks").get_to(i.ramp_ticks);
    one.at("target").get_to(i.target);
    one.at("seed").get_to(i.seed);
    one.at("ramp_out_ticks").get_to(i.ramp_out_ticks);
    one.at("for_ticks").get_to(i.for_ticks);
    one.at("period_ticks").get_to(i.period_ticks);
    one.at("times").get_to(i.times);
    i.trigger = TriggerFromJson(one.at("trigger"));
    one.at("waits").get_to(i.waits);
    one.at("was_true").get_to(i.was_true);
    one.at("fired").get_to(i.fired);
    i.held = NumberFrom(one.at("held"));
    if (!IsSound(i) || !faults.Inject(i)) throw Json::other_error::create(500, "fault", &one);
  }
  faults.ForgetEvents();
  return faults;
}

Json ToJson(const SupervisorState& s) {
  return {{"state", static_cast<int>(s.state)},
          {"cause", static_cast<int>(s.cause)},
          {"governed", s.governed},
          {"silent_ticks", s.silent_ticks},
          {"losses", s.losses},
          {"trips", s.trips}};
}

Json ToJson(const Snapshot& snapshot) {
  const Sample& sample = snapshot.sample;
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
SupervisorState SupervisorFromJson(const Json& json, const Snapshot& snapshot) {
  SupervisorState s;
  json.at("command_p1_psi").get_to(s.demand_psi);
  if (!json.contains("safety")) {
    s.state = snapshot.sample.model_fault ? SafetyState::kFaulted
              : snapshot.commanded        ? SafetyState::kRunning
                                          : SafetyState::kWaiting;
    return s;
  }
  const Json& safety = json.at("safety");
  s.state = EnumOf(safety.at("state"), SafetyState::kFaulted);
  s.cause = EnumOf(safety.at("cause"), SafetyCause::kModelFault);
  safety.at("governed").get_to(s.governed);
  safety.at("silent_ticks").get_to(s.silent_ticks);
  safety.at("losses").get_to(s.losses);
  safety.at("trips").get_to(s.trips);
  return s;
}

Snapshot FromJson(const Json& json) {
  Snapshot snapshot;
  Sample& sample = snapshot.sample;
  model::State& s = sample.state;
  json.at("tick").get_to(sample.tick);
  json.at("p1_psi").get_to(sample.p1_psi);
  json.at("x3_in").get_to(s.x3_in);
  json.at("v3_in_s").get_to(s.v3_in_s);
  json.at("p3_psi").get_to(s.p3_psi);
  json.at("p4_psi").get_to(s.p4_psi);
  json.at("p8_psi").get_to(s.p8_psi);
  json.at("p2_psi").get_to(s.p2_psi);
  s.mode.motion = EnumOf(json.at("motion"), model::Motion::kAtUpperStop);
  s.mode.plunger = EnumOf(json.at("plunger"), model::Plunger::kAtUpperStop);
  json.at("diaphragm_seated").get_to(s.mode.diaphragm_seated);
  json.at("relay_port_full").get_to(s.mode.relay_port_full);
  json.at("unresolved_ticks").get_to(sample.unresolved_ticks);
  json.at("sub_steps").get_to(sample.sub_steps);
  json.at("model_fault").get_to(sample.model_fault);
  json.at("state_hash").get_to(sample.state_hash);
  json.at("commanded").get_to(snapshot.commanded);
  json.at("command_tick").get_to(snapshot.command_tick);
  snapshot.safety = SupervisorFromJson(json, snapshot);
  snapshot.faults = ScheduleFromJson(json.at("faults"));
  return snapshot;
}

Json ToJson(const RunTexts& texts) {
  return {{"configuration", texts.configuration_toml},
          {"load", texts.load_csv},
          {"load_closing", texts.load_closing_csv},
          {"dbc", texts.dbc}};
}

RunTexts TextsFromJson(const Json& json) {
  RunTexts texts;
  json.at("configuration").get_to(texts.configuration_toml);
  json.at("load").get_to(texts.load_csv);
  json.at("load_closing").get_to(texts.load_closing_csv);
  const Json& dbc = json.at("dbc");
  texts.dbc = dbc.is_string() ? std::vector<std::string>{dbc} : dbc.get<std::vector<std::string>>();
  return texts;
}

/// What the checksum is of. Not UTF-8 (a DBC may be Latin-1): replaced alike when written and when read.
std::string ContentText(const Json& content) {
  return content.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string SnapshotText(const Snapshot& snapshot) {
  return ToJson(snapshot).dump();
}

Snapshot ParseSnapshotText(const std::string& text, const std::string& place) {
  try {
    return FromJson(Json::parse(text));
  } catch (const Json::exception& error) {
    throw UsageError(place + ": damaged: " + error.what());
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
    if (!out) throw EnvironmentError(file.string() + ": cannot be written (disk full, or no permission?)");
  }
  std::error_code error;
  std::filesystem::rename(beside, file, error);
  if (error) throw EnvironmentError(file.string() + ": cannot be written: " + error.message());
}

SnapshotFile ReadSnapshot(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file)) throw UsageError(name + ": there is no such file");
  Json whole;
  try {
    in >> whole;
  } catch (const Json::exception& error) {
    throw UsageError(name + ": damaged or no snapshot: it is not JSON");
  }
  if (!whole.is_object() || whole.value("format", Json()) != kFormat)
    throw UsageError(name + ": no servohil snapshot (\"format\" is not \"" + kFormat + "\")");
  try {
    if (const int version = whole.at("version"); version < kOldestVersion || version > kVersion) {
      throw UsageError(name + ": is a snapshot of version " + std::to_string(version) +
                       ", this program reads " + std::to_string(kOldestVersion) + " to " +
                       std::to_string(kVersion));
    }
    const Json& content = whole.at("content");
    if (whole.at("checksum") != Checksum(ContentText(content)))
      throw UsageError(name + ": damaged: its content does not have its checksum");
    return {content.at("program"), FromJson(content.at("state")), TextsFromJson(content.at("texts"))};
  } catch (const Json::exception& error) {
    throw UsageError(name + ": damaged: " + error.what());
  }
}

}  // namespace servohil::app
