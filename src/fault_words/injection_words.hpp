#pragma once
/// Faults in words: what `servohil fault inject`, a request on the control socket and a scenario say, and
/// what is said of faults.

#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "fault/catalogue.hpp"
#include "fault/schedule.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::fault_words {

/// What faults meet in a run.
struct FaultContext {
  fault::Surroundings surroundings;
  const signal_map::SignalMap* signal_map = nullptr;  ///< null: nothing is published
  /// Identifiers that a kernel's filter lets through; empty: all.
  std::vector<can::WantedId> received = {};
};

/// "fraction" = 0.02, "signal" = "x3", "when" = "x3_in > 5"
using Words = std::vector<std::pair<std::string, std::variant<double, std::string>>>;

/// A parameter that faults have besides their own; help and documents are made of these.
struct CommonParameter {
  const char* name;
  const char* unit;
  double minimum;  ///< of numbers; minimum == maximum: a text
  double maximum;
  const char* preset;  ///< what holds without it
  const char* meaning;
  bool (*fits)(const fault::Spec& spec);  ///< whether this fault has it
};
std::span<const CommonParameter> CommonParameters();

/// The run does not have what the fault acts on.
class FaultUnsupported : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct UnderstoodInjection {
  fault::Injection injection;
  std::string warning;  ///< it would have no effect, and why; empty: it has
};

/// @throws UsageError with the nearest right name, or the range; FaultUnsupported
UnderstoodInjection UnderstandInjection(const std::string& fault, const Words& words,
                                        const FaultContext& context);

/// @throws UsageError with the nearest right name
const fault::Spec& RequireFault(const std::string& name);
/// The quantity or message that `words` name for this fault; none: everything.
/// @throws UsageError as UnderstandInjection
std::uint8_t UnderstandTarget(const fault::Spec& spec, const Words& words, const FaultContext& context);

/// "x3_in", "SERVO_Position"; empty where there is none.
std::string TargetName(const fault::Spec& spec, std::uint8_t target, const signal_map::SignalMap* signal_map);
/// "x3_in > 5", "frame 0x123", "air_entrainment starts"; empty: at its time.
std::string TriggerText(const fault::Trigger& trigger);
/// "fault sensor_offset of x3_in starts at tick 1234 (0.1234 s)"
std::string EventText(const fault::Event& event, const signal_map::SignalMap* signal_map);

}  // namespace servohil::fault_words
