#pragma once
/// Every tick's state, from the simulation thread to one that looks at all of them.

#include <ctime>
#include <memory>

#include "rt/ring.hpp"
#include "simulation/run_state.hpp"

namespace servohil::simulation {

/// One producer thread, one consumer thread. What finds it full (a little more than 3 s of ticks) is lost:
/// the consumer sees by the ticks that some are missing.
class SampleFeed {
 public:
  /// @param producer_waits  faster than real time: it sleeps until there is room, and nothing is lost
  explicit SampleFeed(bool producer_waits)
      : ring_(std::make_unique<Samples>()), producer_waits_(producer_waits) {}

  /// Producer. Wait-free, real-time safe (unless it waits).
  void Put(const RunState& now) noexcept {
    constexpr timespec kWait{.tv_sec = 0, .tv_nsec = 200'000};
    while (!ring_->TryPush(now) && producer_waits_) nanosleep(&kWait, nullptr);
  }
  /// Consumer.
  bool TryPop(RunState& now) noexcept { return ring_->TryPop(now); }

 private:
  using Samples = rt::Ring<RunState, 32'768>;
  std::unique_ptr<Samples> ring_;
  bool producer_waits_;
};

}  // namespace servohil::simulation
