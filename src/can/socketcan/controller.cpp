#include "can/socketcan/controller.hpp"

#include <libsocketcan.h>
#include <linux/can/netlink.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>

namespace servohil::can {
namespace {

/// Keeps libsocketcan silent while this lives: it prints by the C library's variable `stderr`, which stands
/// for /dev/null meanwhile. The file descriptor stays, and with it whatever took the stream before, as
/// std::cerr and the log have: no line of another thread is lost.
class Silence {
 public:
  Silence() : lock_(one_at_a_time), shown_(stderr) {
    static std::FILE* const nowhere = std::fopen("/dev/null", "we");
    if (nowhere != nullptr) stderr = nowhere;
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  ~Silence() { stderr = shown_; }

 private:
  inline static std::mutex one_at_a_time;
  std::lock_guard<std::mutex> lock_;
  std::FILE* shown_;
};

ControllerState StateOf(int state) noexcept {
  switch (state) {
    case CAN_STATE_ERROR_WARNING:
      return ControllerState::kErrorWarning;
    case CAN_STATE_ERROR_PASSIVE:
      return ControllerState::kErrorPassive;
    case CAN_STATE_BUS_OFF:
      return ControllerState::kBusOff;
    default:
      return ControllerState::kErrorActive;
  }
}

std::uint8_t Saturated(std::uint16_t count) noexcept {
  constexpr std::uint16_t kMax = 255;
  return static_cast<std::uint8_t>(std::min(count, kMax));
}

}  // namespace

std::optional<Controller> ReadController(const std::string& interface) {
  const Silence silence;
  const char* const name = interface.c_str();
  int state = 0;
  if (can_get_state(name, &state) != 0) return std::nullopt;
  Controller controller;
  controller.state = StateOf(state);
  if (can_berr_counter counter{}; can_get_berr_counter(name, &counter) == 0) {
    controller.has_counters = true;
    controller.tx_errors = Saturated(counter.txerr);
    controller.rx_errors = Saturated(counter.rxerr);
  }
  if (can_bittiming timing{}; can_get_bittiming(name, &timing) == 0) {
    controller.bit_rate_bit_s = timing.bitrate;
    controller.sample_point = timing.sample_point / kSamplePointUnit;
  }
  if (can_clock clock{}; can_get_clock(name, &clock) == 0) controller.clock_hz = clock.freq;
  if (__u32 restart_ms = 0; can_get_restart_ms(name, &restart_ms) == 0) controller.restart_ms = restart_ms;
  return controller;
}

bool SetBitTiming(const std::string& interface, std::uint32_t bit_rate_bit_s, double sample_point) {
  const Silence silence;
  can_bittiming timing{};
  timing.bitrate = bit_rate_bit_s;
  timing.sample_point = static_cast<__u32>(std::lround(sample_point * kSamplePointUnit));
  return can_set_bittiming(interface.c_str(), &timing) == 0;
}

bool SetRestartMs(const std::string& interface, std::uint32_t restart_ms) {
  const Silence silence;
  return can_set_restart_ms(interface.c_str(), restart_ms) == 0;
}

bool Restart(const std::string& interface) {
  const Silence silence;
  return can_do_restart(interface.c_str()) == 0;
}

bool SetUp(const std::string& interface, bool up) {
  const Silence silence;
  return (up ? can_do_start(interface.c_str()) : can_do_stop(interface.c_str())) == 0;
}

}  // namespace servohil::can
