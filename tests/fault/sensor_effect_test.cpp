// What each sensor fault makes of a truth that is known. The truth of quantity 0 is a curve that never comes
// back to where it was, that of quantity 1 is constant.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "bench.hpp"
#include "effect_tests.hpp"
#include "fault/sensors.hpp"

namespace servohil::fault {
namespace {

using testing::Of;

constexpr double kOther = 7.0;

double TruthAt(std::uint64_t tick) {
  return 4.0 + 1e-4 * static_cast<double>(tick) + std::sin(0.01 * static_cast<double>(tick));
}

class Transducer {
 public:
  explicit Transducer(std::vector<Injection> injections) {
    for (const Injection& injection : injections) {
      if (!schedule.Inject(injection)) throw std::length_error("no room");
    }
  }
  /// What is measured of quantity 0 after the next tick.
  double Next() {
    ++tick;
    const std::array truth = {TruthAt(tick), kOther};
    std::array measured = {0.0, 0.0};
    schedule.Advance(tick);
    if (Sensors::Act(schedule, tick)) sensors->Observe(schedule, tick, truth);
    sensors->Measure(schedule, tick, truth, measured);
    EXPECT_EQ(measured[1], kOther) << "the fault is on quantity 0 alone";
    return measured[0];
  }

  Schedule schedule;
  std::unique_ptr<Sensors> sensors = std::make_unique<Sensors>();
  std::uint64_t tick = 0;
};

Injection On0(const char* name, const std::vector<double>& values, std::uint64_t start = 1) {
  Injection injection = testing::Of(name, values);
  injection.target = 0;
  injection.start_tick = start;
  return injection;
}

/// From tick 100 on `expected(tick)`, the truth before; ends with tick 300.
template <typename Expected>
void ExpectFrom100(const char* name, const std::vector<double>& values, Expected&& expected) {
  Injection injection = On0(name, values, 100);
  injection.for_ticks = 200;
  Transducer transducer({injection});
  for (std::uint64_t tick = 1; tick < 400; ++tick) {
    const double measured = transducer.Next();
    if (tick < 100 || tick >= 300) {
      ASSERT_EQ(measured, TruthAt(tick)) << "tick " << tick;
    } else {
      ASSERT_NEAR(measured, expected(tick), 1e-12) << "tick " << tick;
    }
  }
}

void Offset() {
  ExpectFrom100("sensor_offset", {-0.3}, [](std::uint64_t tick) { return TruthAt(tick) - 0.3; });
}
void Gain() {
  ExpectFrom100("sensor_gain", {0.8}, [](std::uint64_t tick) { return 0.8 * TruthAt(tick); });
}
/// 2 per second: 2e-4 per tick.
void Drift() {
  ExpectFrom100("sensor_drift", {2.0},
                [](std::uint64_t tick) { return TruthAt(tick) + 2e-4 * static_cast<double>(tick - 100); });
}
void Quantised() {
  ExpectFrom100("sensor_quantised", {0.25},
                [](std::uint64_t tick) { return std::round(TruthAt(tick) / 0.25) * 0.25; });
}
void Frozen() {
  ExpectFrom100("sensor_frozen", {}, [](std::uint64_t) { return TruthAt(100); });
}
void Zero() {
  ExpectFrom100("sensor_zero", {}, [](std::uint64_t) { return 0.0; });
}
/// 5 ms: 50 ticks; what was true at the start until then.
void Delayed() {
  ExpectFrom100("sensor_delayed", {0.005},
                [](std::uint64_t tick) { return TruthAt(tick < 150 ? 100 : tick - 50); });
  // The longest delay, through a whole turn of the history.
  Transducer slow({On0("sensor_delayed", {1.0})});
  for (std::uint64_t tick = 1; tick < 35'000; ++tick) {
    const double measured = slow.Next();
    ASSERT_EQ(measured, TruthAt(tick <= 10'001 ? 1 : tick - 10'000)) << tick;
  }
}

void FullScale() {
  Transducer transducer({On0("sensor_full_scale", {})});
  EXPECT_EQ(transducer.Next(), HUGE_VAL) << "the contract makes the upper end of the range of it";
}
void OpenWire() {
  Transducer transducer({On0("sensor_open_wire", {})});
  EXPECT_TRUE(std::isnan(transducer.Next())) << "the contract makes all ones of it";
}

/// n values of a Gaussian have a mean within 4 sigma/sqrt(n) and a deviation within 4 sigma/sqrt(2n) of
/// theirs (chance 6e-5 each, and with a fixed seed none at all), and neighbours do not know of one another.
void Noise() {
  constexpr int kCount = 20'000;
  constexpr double kSigma = 0.02;
  const auto noise = [](std::uint64_t seed) {
    Injection injection = On0("sensor_noise", {kSigma});
    injection.seed = seed;
    Transducer transducer({injection});
    std::vector<double> values(kCount);
    for (double& value : values) value = transducer.Next() - TruthAt(transducer.tick);
    return values;
  };
  const std::vector<double> values = noise(3);
  double sum = 0.0;
  double squares = 0.0;
  double products = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    squares += values[i] * values[i];
    if (i > 0) products += values[i] * values[i - 1];
  }
  EXPECT_NEAR(sum / kCount, 0.0, 4 * kSigma / std::sqrt(kCount));
  EXPECT_NEAR(std::sqrt(squares / kCount), kSigma, 4 * kSigma / std::sqrt(2 * kCount));
  EXPECT_NEAR(products / squares, 0.0, 4 / std::sqrt(kCount));
  EXPECT_EQ(noise(3), values) << "the same seed, the same noise";
  EXPECT_NE(noise(4), values);
}

/// Of n publications n p are hit, within 4 sqrt(n p (1 - p)).
void Intermittent() {
  for (const double to_zero : {0.0, 1.0}) {
    constexpr int kCount = 10'000;
    Transducer transducer({On0("sensor_intermittent", {0.1, to_zero})});
    int hit = 0;
    for (int i = 0; i < kCount; ++i) {
      const double measured = transducer.Next();
      if (measured == TruthAt(transducer.tick)) continue;
      EXPECT_TRUE(to_zero == 1.0 ? measured == 0.0 : std::isnan(measured)) << measured;
      ++hit;
    }
    EXPECT_NEAR(hit, 1'000, 4 * std::sqrt(kCount * 0.1 * 0.9));
  }
}

TEST(Sensors, OneThatIsFrozenAgainHoldsWhatIsTrueThen) {
  Injection injection = On0("sensor_frozen", {});
  injection.for_ticks = 10;
  injection.period_ticks = 100;
  injection.times = 2;
  Transducer transducer({injection});
  for (std::uint64_t tick = 1; tick < 300; ++tick) {
    const bool frozen = tick < 11 || (tick >= 101 && tick < 111);
    ASSERT_EQ(transducer.Next(), TruthAt(!frozen ? tick : tick < 11 ? 1 : 101)) << tick;
  }
  EXPECT_EQ(transducer.schedule.size(), 0U);
}

TEST(Sensors, FaultsOfOneQuantityActInTheOrderOfTheCatalogue) {
  Transducer transducer(
      {On0("sensor_quantised", {0.5}), On0("sensor_offset", {0.3}), On0("sensor_gain", {2.0})});
  for (int i = 0; i < 100; ++i) {
    const double measured = transducer.Next();
    ASSERT_EQ(measured, std::round((2.0 * TruthAt(transducer.tick) + 0.3) / 0.5) * 0.5);
  }
}

TEST(Sensors, AFrozenSignalHoldsItsOffset) {
  Transducer transducer({On0("sensor_frozen", {}, 50), On0("sensor_offset", {0.3})});
  double measured = 0.0;
  for (int i = 0; i < 200; ++i) measured = transducer.Next();
  EXPECT_EQ(measured, TruthAt(50) + 0.3);
}

TEST(Sensors, OnTwoQuantitiesAtOnce) {
  Injection other = On0("sensor_offset", {-1.0});
  other.target = 1;
  Schedule schedule;
  ASSERT_TRUE(schedule.Inject(On0("sensor_offset", {0.3})));
  ASSERT_TRUE(schedule.Inject(other));
  ASSERT_EQ(schedule.size(), 2U);
  schedule.Advance(1);
  const std::array truth = {1.0, 2.0};
  std::array measured = {0.0, 0.0};
  const auto sensors = std::make_unique<Sensors>();
  sensors->Observe(schedule, 1, truth);
  sensors->Measure(schedule, 1, truth, measured);
  EXPECT_EQ(measured, (std::array{1.3, 1.0}));
  EXPECT_EQ(schedule.Clear(other.id, 1), 1U);
  EXPECT_EQ(schedule.begin()->target, 0);
  EXPECT_EQ(schedule.Clear(other.id), 1U) << "without a target: all of them";
}

TEST(Sensors, NoneOfThemTouchesTheTruth) {
  testing::Bench with;
  testing::Bench without;
  for (const Spec& spec : Catalogue()) {
    if (!spec.HasSignal()) continue;
    Injection injection = On0(spec.name, {}, 10);
    injection.values = testing::Of(spec.name).values;
    injection.for_ticks = 50;
    ASSERT_TRUE(with.simulation.Faults().Inject(injection));
  }
  for (int i = 0; i < 100; ++i) {
    with.p1_psi = without.p1_psi = 30.0 + 0.01 * i;
    ASSERT_EQ(with.Run(1).state_hash, without.Run(1).state_hash) << i;
  }
  EXPECT_EQ(with.simulation.Faults().size(), 0U);
}

}  // namespace

const testing::Effects testing::kSensorEffects = {
    {"sensor_offset", Offset},       {"sensor_gain", Gain},
    {"sensor_drift", Drift},         {"sensor_noise", Noise},
    {"sensor_quantised", Quantised}, {"sensor_frozen", Frozen},
    {"sensor_zero", Zero},           {"sensor_full_scale", FullScale},
    {"sensor_open_wire", OpenWire},  {"sensor_intermittent", Intermittent},
    {"sensor_delayed", Delayed},
};

}  // namespace servohil::fault
