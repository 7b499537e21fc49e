#include "can/bus_monitor.hpp"

#include <gtest/gtest.h>

namespace servohil::can {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A bus that is looked at each 100 ms.
class Watched {
 public:
  explicit Watched(const BusMonitorSettings& settings = {}) : monitor_("bus", settings) {
    seen.now_ns = 1000 * kMs;
  }

  std::vector<std::string> Look(std::int64_t after_ms = 100) {
    seen.now_ns += after_ms * kMs;
    std::vector<std::string> texts;
    for (const BusMonitor::Notice& remark : monitor_.Look(seen)) texts.push_back(remark.text);
    return texts;
  }
  const BusCondition& Now() const { return monitor_.Condition(); }
  bool Restart() { return monitor_.TakeRestart(); }
  void SetController(ControllerState state, std::uint8_t tx_errors = 0, std::uint8_t rx_errors = 0) {
    if (!seen.link) seen.link.emplace();
    seen.link->controller = {.state = state,
                             .has_counters = true,
                             .tx_errors = tx_errors,
                             .rx_errors = rx_errors,
                             .restart_ms = restart_ms};
  }

  BusObservation seen;
  std::uint32_t restart_ms = 0;

 private:
  BusMonitor monitor_;
};

using Texts = std::vector<std::string>;

TEST(BusMonitor, SaysNothingOfAHealthyBus) {
  Watched bus;
  for (int i = 0; i < 50; ++i) {
    bus.seen.statistics.received += 10;
    bus.seen.statistics.sent += 22;
    EXPECT_EQ(bus.Look(), Texts{});
  }
  EXPECT_TRUE(bus.Now().IsHealthy());
}

TEST(BusMonitor, TellsEachStateOnce) {
  Watched bus;
  bus.SetController(ControllerState::kErrorActive);
  bus.Look();
  bus.SetController(ControllerState::kErrorPassive, 128, 3);
  EXPECT_EQ(bus.Look(),
            Texts{"bus: error-passive, was error-active for 0.1 s; error counters: transmit 128, receive 3"});
  EXPECT_EQ(bus.Look(), Texts{});
  bus.seen.link.reset();  // not asked each time
  EXPECT_EQ(bus.Look(), Texts{});
  EXPECT_EQ(bus.Now().state, BusState::kErrorPassive);
  bus.SetController(ControllerState::kErrorActive);
  bus.seen.statistics.dropped_disconnected = 4;
  EXPECT_EQ(bus.Look(), Texts{"bus: error-active, was error-passive for 0.3 s; 4 frames not sent meanwhile"});
}

TEST(BusMonitor, DownAndGoneAreStatesOfTheirOwn) {
  Watched bus;
  bus.Look();
  bus.seen.down = true;
  bus.seen.statistics.dropped_disconnected = 2;
  EXPECT_EQ(bus.Look(), Texts{"bus: down, was error-active for 0.1 s"});
  bus.seen.down = false;
  bus.seen.gone = true;
  EXPECT_EQ(bus.Look(), Texts{"bus: gone, was down for 0.1 s"});
  bus.seen.gone = false;
  bus.seen.statistics.dropped_disconnected = 7;
  EXPECT_EQ(bus.Look(), Texts{"bus: error-active, was gone for 0.1 s; 7 frames not sent meanwhile"});
}

TEST(BusMonitor, AFaultIsToldWhenItBeginsAndASecondAfterItWasSeenLast) {
  Watched bus;
  bus.Look();
  bus.seen.statistics.dropped_queue_full = 5;
  EXPECT_EQ(bus.Look(),
            Texts{"bus: transmit queue full: 5 frames not sent; is the bus overloaded, or nobody there to "
                  "acknowledge?"});
  for (int i = 0; i < 20; ++i) {
    ++bus.seen.statistics.dropped_queue_full;
    EXPECT_EQ(bus.Look(), Texts{});
    EXPECT_TRUE(bus.Now().Has(BusFault::kQueueFull));
  }
  EXPECT_EQ(bus.Look(900), Texts{});
  EXPECT_EQ(bus.Look(100), Texts{"bus: no more transmit queue full; it was 25 frames"});
  EXPECT_TRUE(bus.Now().IsHealthy());
  EXPECT_EQ(bus.Now().not_sent, 25U);
}

TEST(BusMonitor, NamesOverrunsAndConflictsWithTheirNumbers) {
  Watched bus;
  bus.Look();
  bus.seen.statistics.receive_overflows = 3;
  bus.seen.errors.controller_overflows = 1;
  bus.seen.conflicts = 1;
  EXPECT_EQ(bus.Look(), (Texts{"bus: receive overrun: 4 frames lost before they could be read",
                               "bus: id conflict: another node sends identifiers that are ours (1 frame)"}));
  EXPECT_EQ(bus.Now().overruns, 4U);
  EXPECT_EQ(bus.Now().conflicts, 1U);
}

/// Twenty destroyed frames and nothing good between them.
TEST(BusMonitor, NothingButErrorFramesIsABitRateMismatch) {
  Watched bus;
  bus.Look();
  const auto disturb = [&](std::uint64_t frames) {
    bus.seen.errors.frames += frames;
    bus.seen.errors.disturbances += frames;
  };
  disturb(19);
  EXPECT_EQ(bus.Look(), Texts{});
  ++bus.seen.statistics.received;  // a good one between them: a disturbed bus, but the right bit rate
  EXPECT_EQ(bus.Look(), Texts{});
  disturb(19);
  EXPECT_EQ(bus.Look(), Texts{});
  disturb(1);
  EXPECT_EQ(bus.Look().size(), 1U);
  EXPECT_TRUE(bus.Now().Has(BusFault::kBitRateMismatch));
  ++bus.seen.statistics.received;
  EXPECT_EQ(bus.Look(), Texts{"bus: no more bit-rate mismatch; it was 20 frames"});
}

TEST(BusMonitor, FramesThatTheKernelCountsAreGoodOnes) {
  Watched bus;
  bus.SetController(ControllerState::kErrorActive);
  bus.Look();
  for (int i = 0; i < 10; ++i) {
    bus.seen.errors.frames += 10;
    bus.seen.errors.disturbances += 10;
    bus.seen.link->rx_packets += 10;  // the error frames themselves, as some drivers count them
    ++bus.seen.link->tx_packets;      // somebody acknowledged
    EXPECT_EQ(bus.Look(), Texts{});
  }
  for (int i = 0; i < 2; ++i) {
    bus.seen.errors.frames += 10;
    bus.seen.errors.disturbances += 10;
    bus.seen.link->rx_packets += 10;
    bus.Look();
  }
  EXPECT_TRUE(bus.Now().Has(BusFault::kBitRateMismatch));
}

/// A transmitter that is alone stays error-passive at 128: ISO 11898-1 does not count missing
/// acknowledgements further.
/// A driver that reports no bus errors: there are no error frames to describe.
TEST(BusMonitor, AReceiverThatGetsNothingGoodIsOnABusOfAnotherBitRate) {
  Watched bus;
  bus.SetController(ControllerState::kErrorPassive, 0, 128);
  const Texts told = bus.Look();
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[1],
            "bus: bit-rate mismatch? nothing but errors: do all nodes run at 500000 "
            "bit/s? else wires or termination");
}

/// Seen of the kernel's driver for the SJA1000, whose registers then read as 0xFF.
TEST(BusMonitor, AnAdapterWhoseRegistersAreAllOnesDoesNotAnswer) {
  Watched bus;
  bus.SetController(ControllerState::kErrorActive, 3, 4);
  bus.Look();
  bus.SetController(ControllerState::kErrorActive, 255, 255);
  EXPECT_EQ(bus.Look(), Texts{"bus: the adapter does not answer; is it plugged in firmly?"});
  EXPECT_EQ(bus.Look(5000), Texts{});
  EXPECT_FALSE(bus.Now().Has(BusFault::kBitRateMismatch));
  EXPECT_EQ(bus.Now().tx_errors, 3);  // the last that it told
  bus.SetController(ControllerState::kErrorActive, 0, 0);
  EXPECT_EQ(bus.Look(), Texts{"bus: the adapter answers again"});
  EXPECT_EQ(bus.Now().tx_errors, 0);
}

TEST(BusMonitor, APassiveSenderWhomNobodyHearsIsAlone) {
  Watched bus;
  bus.SetController(ControllerState::kErrorPassive, 128, 0);
  bus.Look();
  bus.Look(1000);
  EXPECT_TRUE(bus.Now().Has(BusFault::kNoAcknowledge));
  EXPECT_FALSE(bus.Now().Has(BusFault::kBitRateMismatch));
}

TEST(BusMonitor, RestartsWithAWaitThatDoublesUpToTheMost) {
  Watched bus({.backoff_ns = 100 * kMs, .most_backoff_ns = 500 * kMs});
  bus.SetController(ControllerState::kErrorActive);
  bus.Look();
  for (const int wait_ms : {100, 200, 400, 500, 500}) {
    bus.SetController(ControllerState::kBusOff);
    EXPECT_EQ(bus.Look(10).back(), "bus: restart in " + std::to_string(wait_ms) + " ms");
    bus.Look(wait_ms - 1);
    EXPECT_FALSE(bus.Restart());
    bus.Look(1);
    EXPECT_TRUE(bus.Restart());
    EXPECT_FALSE(bus.Restart()) << "once";
    bus.SetController(ControllerState::kErrorActive);
    bus.Look(10);
  }
  bus.Look(2000);  // it has held
  bus.SetController(ControllerState::kBusOff);
  EXPECT_EQ(bus.Look(10).back(), "bus: restart in 100 ms");
  EXPECT_EQ(bus.Now().bus_offs, 6U);
}

TEST(BusMonitor, ARestartThatDidNotHelpIsTriedAgainLater) {
  Watched bus({.backoff_ns = 100 * kMs, .most_backoff_ns = 500 * kMs});
  bus.SetController(ControllerState::kBusOff);
  bus.Look();
  bus.Look(100);
  EXPECT_TRUE(bus.Restart());
  bus.Look(100);
  bus.Look(199);
  EXPECT_FALSE(bus.Restart());
  bus.Look(1);
  EXPECT_TRUE(bus.Restart());
}

TEST(BusMonitor, LeavesTheRestartToTheKernelWhereItDoesSo) {
  Watched bus;
  bus.restart_ms = 50;
  bus.SetController(ControllerState::kBusOff);
  EXPECT_EQ(bus.Look().back(), "bus: the kernel restarts the controller within 50 ms");
  bus.Look(60'000);
  EXPECT_FALSE(bus.Restart());
}

/// Its error frame and the kernel's state tell of one bus-off, in either order.
TEST(BusMonitor, ABusOffIsCountedOnce) {
  for (const bool frame_first : {true, false}) {
    Watched bus;
    bus.SetController(ControllerState::kErrorActive);
    bus.Look();
    const auto frame = [&] {
      bus.seen.errors.state = ControllerState::kBusOff;
      ++bus.seen.errors.frames;
      ++bus.seen.errors.bus_offs;
    };
    if (frame_first) frame();
    bus.SetController(ControllerState::kBusOff);
    bus.Look();
    if (!frame_first) frame();
    bus.Look();
    EXPECT_EQ(bus.Now().bus_offs, 1U);
  }
}

TEST(BusCondition, TheWorstOfSeveral) {
  BusCondition a{.state = BusState::kErrorPassive, .faults = 1, .tx_errors = 130, .error_frames = 3};
  const BusCondition b{.state = BusState::kErrorWarning, .faults = 8, .rx_errors = 97, .error_frames = 4};
  const BusCondition worst = Worst(a, b);
  EXPECT_EQ(worst.state, BusState::kErrorPassive);
  EXPECT_EQ(worst.faults, 9);
  EXPECT_EQ(worst.tx_errors, 130);
  EXPECT_EQ(worst.rx_errors, 97);
  EXPECT_EQ(worst.error_frames, 7U);
}

}  // namespace
}  // namespace servohil::can
