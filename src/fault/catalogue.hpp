#pragma once
/// The faults there are: one table, from which help, documentation and checks come.

#include <array>
#include <cstdint>
#include <span>
#include <variant>

#include "fault/acts.hpp"
#include "fault/injection.hpp"
#include "model/parameters.hpp"

namespace servohil::fault {

struct ParameterSpec {
  const char* name = nullptr;  ///< "fraction"; null: there is no such parameter
  const char* unit = "";       ///< empty where there is none
  double minimum = 0.0;        ///< inclusive
  double maximum = 0.0;
  double preset = 0.0;  ///< where none is given
  const char* meaning = "";
};

/// What a fault acts on.
enum class Part : std::uint8_t {
  kOil,
  kSupply,
  kRelay,
  kPiston,
  kLoad,
  kStabilizer,
  kSensors,
  kBus,
  kEmulator
};
const char* NameOf(Part part) noexcept;

/// What must be there for a fault to have an effect.
enum class Needs : std::uint8_t {
  kNothing,
  kFullPhysics,
  kStabilizer,
  kBus,          ///< frames that come and go
  kCounter,      ///< of the protection of published messages
  kChecksum,     ///< of the protection of published messages
  kErrorFrames,  ///< a transport that carries them
  kRealTime      ///< a deadline to miss
};

struct Spec {
  std::uint8_t id = 0;         ///< the same for ever: recordings hold it
  const char* name = nullptr;  ///< "air_entrainment"
  Part part = Part::kOil;
  std::array<ParameterSpec, kMaxParameters> parameters{};
  const char* effect = nullptr;  ///< one sentence
  Act act = ParameterAct{nullptr};
  Needs needs = Needs::kNothing;
  bool varies = false;  ///< a ParameterAct that changes at each tick, not only while it ramps
  bool random = false;  ///< has a seed

  template <typename Kind>
  bool ActsAs() const noexcept {
    return std::holds_alternative<Kind>(act);
  }
  /// Is for one quantity, which must be named: the parameter "signal".
  bool HasSignal() const noexcept { return ActsAs<SensorAct>(); }
  /// Is for one message or all: the parameter "message".
  bool HasMessage() const noexcept { return ActsAs<TransmitAct>(); }
};

/// The one that needs the past of a signal.
inline constexpr std::uint8_t kSensorDelayed = 60;

std::span<const Spec> Catalogue() noexcept;
/// Null: there is none of this number. Real-time safe.
const Spec* Find(std::uint8_t id) noexcept;

/// What a run has that faults may need.
struct Surroundings {
  const model::Parameters* unfaulted = nullptr;
  bool has_bus = true;
  bool real_time = true;
  bool counter = false;                       ///< a published message has one in its protection
  bool checksum = false;                      ///< a published message has one in its protection
  const char* why_no_error_frames = nullptr;  ///< null: its transports carry them
};

/// "model.physics = "full""; null: nothing is needed.
const char* OnlyWith(Needs needs) noexcept;
/// Why the run does not have what the fault acts on; null where it has. Real-time safe.
const char* Unsupported(const Spec& spec, const Surroundings& surroundings) noexcept;
}  // namespace servohil::fault
