#include "fault_words/injection_words.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/nearest_name.hpp"
#include "fault_words/effect.hpp"
#include "model/ticks.hpp"
#include "simulation/quantity.hpp"

namespace servohil::fault_words {
namespace {

using fault::Injection;
using fault::Spec;
using fault::Trigger;
using Word = Words::value_type::second_type;

constexpr double kMaxSeconds = 1e6;
constexpr double kMaxTimes = 1e9;
constexpr double kMaxSeed = 9007199254740992.0;  // 2^53: whole numbers to there
constexpr std::uint32_t kMaxStandardId = 0x7FF;
constexpr std::uint32_t kMaxExtendedId = 0x1FFFFFFF;
constexpr std::size_t kMaxShown = 60;  // of what somebody else wrote

bool Any(const Spec&) {
  return true;
}

// Those that are texts have no range.
constexpr std::array kCommon = std::to_array<CommonParameter>({
    {"signal", "", 0, 0, "must be named", "the quantity whose sensor it is: x3, p3, ...",
     [](const Spec& s) { return s.HasSignal(); }},
    {"message", "", 0, 0, "all", "the published message that it hits: SERVO_Position, ...",
     [](const Spec& s) { return s.HasMessage(); }},
    {"seed", "", 0, kMaxSeed, "0", "the same seed gives the same run",
     [](const Spec& s) { return s.random; }},
    {"at_s", "s", 0, kMaxSeconds, "now", "simulated time at which it starts; with a trigger: not before",
     Any},
    {"ramp_s", "s", 0, kMaxSeconds, "0", "rises in this time, and falls again in as long at its end", Any},
    {"ramp_out_s", "s", 0, kMaxSeconds, "ramp_s", "falls in this time", Any},
    {"for_s", "s", 0, kMaxSeconds, "until cleared", "from its start to the beginning of its fall", Any},
    {"every_s", "s", 1e-4, kMaxSeconds, "once", "starts again each time that this has passed", Any},
    {"duty", "", 0, 1, "0.5", "share of every_s for which it lasts, instead of for_s", Any},
    {"times", "", 0, kMaxTimes, "1; with every_s 0", "how often; 0: without end", Any},
    {"when", "", 0, 0, "", "starts when this comes true: \"x3_in > 5\", \"p3_psi < 40\"", Any},
    {"when_frame", "", 0, 0, "", "starts when the frame with this identifier is received: 0x100", Any},
    {"when_fault", "", 0, 0, "", "starts with the tick after the start of this other fault", Any},
});

std::string Shown(const Word& word) {
  const double* number = std::get_if<double>(&word);
  return number != nullptr ? base::Formatted("%g", *number)
                           : std::get<std::string>(word).substr(0, kMaxShown);
}

std::string Suggestion(const std::string& name, const std::vector<std::string>& names) {
  return "; " + base::DidYouMean(name.substr(0, kMaxShown), names, "there are " + base::Listed(names));
}

double RequireNumber(const std::string& name, const Word& word, double minimum, double maximum,
                     const char* unit) {
  const double* number = std::get_if<double>(&word);
  if (number != nullptr && *number >= minimum && *number <= maximum) return *number;
  throw base::UsageError(base::Formatted("%s = %s: must be a number from %g to %g%s%s", name.c_str(),
                                         Shown(word).c_str(), minimum, maximum, *unit == 0 ? "" : " ", unit));
}

const std::string& RequireText(const std::string& name, const Word& word, const char* expected) {
  if (const auto* text = std::get_if<std::string>(&word)) return *text;
  throw base::UsageError(name + " = " + Shown(word) + ": must be " + expected);
}

/// By its name, or by its signal's in any case of letters: x3_in, X3, x3.
const simulation::Quantity& RequireQuantity(const std::string& name) {
  std::vector<std::string> names;
  for (const simulation::Quantity& quantity : simulation::Quantities()) {
    const bool same =
        name.size() == std::string(quantity.signal).size() && base::EditDistance(name, quantity.signal) == 0;
    if (name == quantity.name || same) return quantity;
    names.emplace_back(quantity.name);
  }
  throw base::UsageError("there is no quantity " + name.substr(0, kMaxShown) + Suggestion(name, names));
}

std::uint8_t RequireMessage(const std::string& name, const signal_map::SignalMap* signal_map) {
  std::vector<std::string> names;
  for (std::size_t i = 0; signal_map != nullptr && i < signal_map->MessageCount(); ++i) {
    if (signal_map->MessageOf(i).name == name) return static_cast<std::uint8_t>(i);
    names.push_back(signal_map->MessageOf(i).name);
  }
  throw base::UsageError("there is no published message " + name.substr(0, kMaxShown) +
                         Suggestion(name, names));
}

/// "x3_in > 5"
Trigger ConditionOf(const std::string& text) {
  const std::size_t sign = text.find_first_of("<>");
  const std::string form = "when = " + text.substr(0, kMaxShown) +
                           ": expected QUANTITY > NUMBER or QUANTITY < NUMBER, such as \"x3_in > 5\"";
  if (sign == std::string::npos) throw base::UsageError(form);
  const auto trimmed = [](const std::string& part) {
    const std::size_t first = part.find_first_not_of(' ');
    return first == std::string::npos ? std::string()
                                      : part.substr(first, part.find_last_not_of(' ') - first + 1);
  };
  const std::string name = trimmed(text.substr(0, sign));
  const std::string number = trimmed(text.substr(sign + 1));
  Trigger trigger{.kind = Trigger::Kind::kCondition};
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), trigger.threshold);
  if (error != std::errc{} || end != number.data() + number.size() || !std::isfinite(trigger.threshold))
    throw base::UsageError(form);
  const simulation::Quantity& quantity = RequireQuantity(name);
  if (!quantity.repeatable) {
    throw base::UsageError("when = " + text.substr(0, kMaxShown) + ": " + quantity.name +
                           " is the machine's doing, no replay would repeat it");
  }
  trigger.quantity = static_cast<std::uint8_t>(simulation::IndexOf(quantity));
  trigger.above = text[sign] == '>';
  return trigger;
}

Trigger FrameOf(const Word& word) {
  std::uint32_t id = std::numeric_limits<std::uint32_t>::max();
  if (const double* number = std::get_if<double>(&word)) {
    if (*number >= 0 && *number <= kMaxExtendedId && *number == std::floor(*number))
      id = static_cast<std::uint32_t>(*number);
  } else {
    const std::string& text = std::get<std::string>(word);
    const bool hexadecimal = text.rfind("0x", 0) == 0;
    const char* last = text.data() + text.size();
    const auto [end, error] =
        std::from_chars(text.data() + (hexadecimal ? 2 : 0), last, id, hexadecimal ? 16 : 10);
    if (error != std::errc{} || end != last) id = std::numeric_limits<std::uint32_t>::max();
  }
  if (id > kMaxExtendedId)
    throw base::UsageError("when_frame = " + Shown(word) +
                           ": must be an identifier from 0 to 0x1FFFFFFF, such as 0x100");
  return {.kind = Trigger::Kind::kFrame, .frame_id = id, .extended = id > kMaxStandardId};
}

/// A frame that never comes would start nothing.
void RequireReceived(const Trigger& trigger, const std::vector<can::WantedId>& received) {
  const auto is_it = [&](const can::WantedId& wanted) {
    return wanted.extended == trigger.extended && ((wanted.id ^ trigger.frame_id) & wanted.mask) == 0;
  };
  if (trigger.kind != Trigger::Kind::kFrame || received.empty() ||
      std::any_of(received.begin(), received.end(), is_it))
    return;
  std::string all;
  for (const can::WantedId& wanted : received)
    all += (all.empty() ? "" : ", ") + base::Formatted("0x%X", wanted.id);
  throw base::UsageError(
      base::Formatted("when_frame = 0x%X: is not received on a kernel's interface; received are ",
                      trigger.frame_id) +
      all);
}

/// The time line as it was asked for.
struct Asked {
  std::optional<double> ramp_out_s;
  std::optional<double> for_s;
  std::optional<double> every_s;
  std::optional<double> duty;
  std::optional<double> times;
  int triggers = 0;
};

std::uint64_t LengthTicks(double seconds) {
  return std::max<std::uint64_t>(1, model::TicksOf(seconds));
}

void SetTimes(Injection& injection, const Asked& asked) {
  const bool triggered = injection.trigger.kind != Trigger::Kind::kTime;
  injection.times = asked.every_s ? 0 : 1;
  if (!asked.times) return;
  if (!asked.every_s && !triggered)
    throw base::UsageError("times: needs every_s, when, when_frame or when_fault");
  injection.times = static_cast<std::uint32_t>(*asked.times);
  if (injection.times != 1 && injection.for_ticks == 0)
    throw base::UsageError("times: needs for_s: it would never end");
}

void SetTimeLine(Injection& injection, const Asked& asked) {
  injection.ramp_out_ticks = asked.ramp_out_s ? model::TicksOf(*asked.ramp_out_s) : injection.ramp_ticks;
  if (asked.for_s) injection.for_ticks = LengthTicks(*asked.for_s);
  if (asked.duty && !asked.every_s) throw base::UsageError("duty: needs every_s");
  if (asked.duty && asked.for_s) throw base::UsageError("duty: not together with for_s, which says the same");
  if (asked.every_s) {
    constexpr double kHalf = 0.5;
    injection.period_ticks = LengthTicks(*asked.every_s);
    if (!asked.for_s) injection.for_ticks = LengthTicks(*asked.every_s * asked.duty.value_or(kHalf));
    if (injection.for_ticks + injection.ramp_out_ticks > injection.period_ticks)
      throw base::UsageError("every_s: each pulse and its ramp out must fit into it");
  }
  SetTimes(injection, asked);
  if (asked.triggers > 1) throw base::UsageError("only one of when, when_frame and when_fault is possible");
}

/// @return false: there is no such common parameter
bool SetCommon(const std::string& name, const Word& word, const Spec& spec, Injection& injection,
               Asked& asked) {
  const auto* const common = std::find_if(kCommon.begin(), kCommon.end(), [&](const CommonParameter& c) {
    return name == c.name && c.fits(spec);
  });
  if (common == kCommon.end()) return false;
  const auto number = [&] {
    return RequireNumber(name, word, common->minimum, common->maximum, common->unit);
  };
  if (name == "seed") injection.seed = static_cast<std::uint64_t>(number());
  if (name == "at_s") injection.start_tick = model::TicksOf(number()) + 1;
  if (name == "ramp_s") injection.ramp_ticks = model::TicksOf(number());
  if (name == "ramp_out_s") asked.ramp_out_s = number();
  if (name == "for_s") asked.for_s = number();
  if (name == "every_s") asked.every_s = number();
  if (name == "duty") asked.duty = number();
  if (name == "times") asked.times = number();
  if (name.rfind("when", 0) != 0) return true;
  ++asked.triggers;
  injection.waits = true;
  if (name == "when")
    injection.trigger = ConditionOf(RequireText(name, word, "a text such as \"x3_in > 5\""));
  if (name == "when_frame") injection.trigger = FrameOf(word);
  if (name == "when_fault")
    injection.trigger = {.kind = Trigger::Kind::kFault,
                         .fault = RequireFault(RequireText(name, word, "the name of a fault")).id};
  return true;
}

void SetOwn(const std::string& name, const Word& word, const Spec& spec, Injection& injection) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < spec.parameters.size() && spec.parameters[i].name != nullptr; ++i) {
    const fault::ParameterSpec& p = spec.parameters[i];
    if (name == p.name) {
      injection.values[i] = RequireNumber(name, word, p.minimum, p.maximum, p.unit);
      return;
    }
    names.emplace_back(p.name);
  }
  for (const CommonParameter& common : kCommon) {
    if (common.fits(spec)) names.emplace_back(common.name);
  }
  throw base::UsageError(std::string(spec.name) + " has no parameter " + name.substr(0, kMaxShown) +
                         Suggestion(name, names));
}

}  // namespace

std::span<const CommonParameter> CommonParameters() {
  return kCommon;
}

const Spec& RequireFault(const std::string& name) {
  std::vector<std::string> names;
  for (const Spec& spec : fault::Catalogue()) {
    if (name == spec.name) return spec;
    names.emplace_back(spec.name);
  }
  const std::string shown = name.substr(0, kMaxShown);
  throw base::UsageError("there is no fault " + shown + "; " +
                         base::DidYouMean(shown, names, "`servohil fault list` has all"));
}

std::uint8_t UnderstandTarget(const Spec& spec, const Words& words, const FaultContext& context) {
  std::uint8_t target = Injection::kEverything;
  for (const auto& [name, word] : words) {
    if (name == "signal" && spec.HasSignal())
      target = static_cast<std::uint8_t>(
          simulation::IndexOf(RequireQuantity(RequireText(name, word, "a quantity's name"))));
    if (name == "message" && spec.HasMessage())
      target = RequireMessage(RequireText(name, word, "a message's name"), context.signal_map);
  }
  return target;
}

UnderstoodInjection UnderstandInjection(const std::string& fault, const Words& words,
                                        const FaultContext& context) {
  const Spec& spec = RequireFault(fault);
  if (const char* why = fault::Unsupported(spec, context.surroundings))
    throw FaultUnsupported(std::string(spec.name) + ": " + why);
  Injection injection;
  injection.id = spec.id;
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) injection.values[i] = spec.parameters[i].preset;
  Asked asked;
  for (const auto& [name, word] : words) {
    if (!SetCommon(name, word, spec, injection, asked)) SetOwn(name, word, spec, injection);
  }
  injection.target = UnderstandTarget(spec, words, context);
  if (spec.HasSignal() && injection.target == Injection::kEverything)
    throw base::UsageError(std::string(spec.name) +
                           ": signal is missing: the quantity whose sensor it is, such as signal=x3");
  SetTimeLine(injection, asked);
  RequireReceived(injection.trigger, context.received);
  return {injection, WhyNoEffect(spec, injection, context)};
}

std::string TargetName(const Spec& spec, std::uint8_t target, const signal_map::SignalMap* signal_map) {
  if (target == Injection::kEverything) return {};
  if (spec.HasSignal() && target < simulation::Quantities().size())
    return simulation::Quantities()[target].name;
  if (spec.HasMessage() && signal_map != nullptr && target < signal_map->MessageCount())
    return signal_map->MessageOf(target).name;
  return std::to_string(target);
}

std::string TriggerText(const Trigger& trigger) {
  switch (trigger.kind) {
    case Trigger::Kind::kTime:
      break;
    case Trigger::Kind::kCondition:
      return base::Formatted("%s %c %g", simulation::Quantities()[trigger.quantity].name,
                             trigger.above ? '>' : '<', trigger.threshold);
    case Trigger::Kind::kFrame:
      return base::Formatted("frame 0x%X", trigger.frame_id);
    case Trigger::Kind::kFault:
      return std::string(fault::Find(trigger.fault)->name) + " starts";
  }
  return {};
}

std::string EventText(const fault::Event& event, const signal_map::SignalMap* signal_map) {
  static constexpr std::array kWhat = {"waits from", "starts at", "ends at", "is changed at",
                                       "is cleared at"};
  const Spec& spec = *fault::Find(event.id);
  const std::string target = TargetName(spec, event.target, signal_map);
  return std::string("fault ") + spec.name + (target.empty() ? "" : " of " + target) + " " +
         kWhat[static_cast<std::size_t>(event.kind)] +
         base::Formatted(" tick %llu (%.4f s)", static_cast<unsigned long long>(event.tick),
                         model::SecondsOf(event.tick)) +
         (event.pulse == 0 ? "" : base::Formatted(", pulse %u", event.pulse + 1));
}

}  // namespace servohil::fault_words
