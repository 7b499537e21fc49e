#include "can/dbc/codec.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

#include "can/dbc/j1939.hpp"

namespace servohil::can {
namespace {

using Bytes = std::array<std::uint8_t, 8>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Signal Intel(int start, int length, bool is_signed = false) {
  Signal signal;
  signal.start_bit = start;
  signal.length_bits = length;
  signal.is_signed = is_signed;
  return signal;
}

Signal Motorola(int start, int length, bool is_signed = false) {
  Signal signal = Intel(start, length, is_signed);
  signal.little_endian = false;
  return signal;
}

TEST(Codec, ReadsTheWorkedFrameOfTheCommand) {
  // P1_Demand 12|20@1+ (0.001,0): 123.456 psi = 123456 = 0x1E240, low nibble in the high nibble of byte 1.
  Signal p1 = Intel(12, 20);
  p1.factor = 0.001;
  const Bytes data{0xAB, 0x0C, 0x24, 0x1E};
  EXPECT_EQ(ExtractRaw(p1, data), 0x1E240);
  EXPECT_DOUBLE_EQ(Decode(p1, data), 123.456);
}

TEST(Codec, MotorolaStartsAtTheMostSignificantBit) {
  // 7|16@0: bytes 0 and 1, big-endian. 3|12@0: low nibble of byte 0, then byte 1.
  const Bytes data{0x12, 0x34, 0x56};
  EXPECT_EQ(ExtractRaw(Motorola(7, 16), data), 0x1234);
  EXPECT_EQ(ExtractRaw(Motorola(3, 12), data), 0x234);
  EXPECT_EQ(ExtractRaw(Motorola(1, 9), data), 0b10'0011010);
}

TEST(Codec, ExtendsTheSign) {
  const Bytes data{0xFF, 0x80};
  EXPECT_EQ(ExtractRaw(Intel(0, 1, true), data), -1);
  EXPECT_EQ(ExtractRaw(Intel(0, 8, true), data), -1);
  EXPECT_EQ(ExtractRaw(Intel(8, 8, true), data), -128);
  EXPECT_EQ(ExtractRaw(Intel(8, 8, false), data), 128);
}

TEST(Codec, UnsignedValuesAboveTwoToThe63Decode) {
  const Bytes data{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
  EXPECT_EQ(Decode(Intel(0, 64), data), 0x1p64);  // 2^64 - 1 rounds to 2^64
  EXPECT_EQ(Decode(Intel(0, 64, true), data), -1.0);
}

TEST(Codec, RoundsToTheNearestStep) {
  Signal signal = Intel(0, 16);
  signal.factor = 0.5;
  signal.offset = -10.0;
  Bytes data{};
  EXPECT_TRUE(Encode(signal, -7.3, data));  // 5.4 steps
  EXPECT_EQ(ExtractRaw(signal, data), 5);
  EXPECT_TRUE(Encode(signal, -7.2, data));  // 5.6 steps
  EXPECT_EQ(ExtractRaw(signal, data), 6);
}

TEST(Codec, SaturatesAtTheField) {
  Bytes data{};
  EXPECT_FALSE(Encode(Intel(0, 8), 256.0, data));
  EXPECT_EQ(data[0], 255);
  EXPECT_FALSE(Encode(Intel(0, 8), -1.0, data));
  EXPECT_EQ(data[0], 0);
  EXPECT_FALSE(Encode(Intel(0, 8, true), 128.0, data));
  EXPECT_EQ(data[0], 0x7F);
  EXPECT_FALSE(Encode(Intel(0, 8, true), -129.0, data));
  EXPECT_EQ(data[0], 0x80);
  EXPECT_FALSE(Encode(Intel(0, 1, true), 1.0, data));  // one signed bit: 0 or -1
  EXPECT_EQ(ExtractRaw(Intel(0, 1, true), data), 0);
}

TEST(Codec, SaturatesAtTheStatedRange) {
  Signal signal = Intel(0, 16, true);
  signal.factor = 0.1;
  signal.minimum = -5.0;
  signal.maximum = 5.0;
  Bytes data{};
  EXPECT_FALSE(Encode(signal, 5.2, data));
  EXPECT_EQ(ExtractRaw(signal, data), 50);
  EXPECT_FALSE(Encode(signal, -kInfinity, data));
  EXPECT_EQ(ExtractRaw(signal, data), -50);
  EXPECT_TRUE(Encode(signal, 5.04, data));  // nearest is 5.0: inside
  EXPECT_EQ(ExtractRaw(signal, data), 50);
}

TEST(Codec, ARangeWhoseEndLiesBetweenStepsIsNotExceeded) {
  Signal signal = Intel(0, 16);
  signal.factor = 0.7;
  signal.maximum = 1.0;  // 1.43 steps
  Bytes data{};
  EXPECT_FALSE(Encode(signal, 1.2, data));
  EXPECT_EQ(ExtractRaw(signal, data), 1);
}

TEST(Codec, ARangeThatIsAWholeNumberOfStepsIsReachedThoughDoublesAreNot) {
  Signal x3 = Intel(0, 16);  // (12.107 + 1) / 0.0002 is 65534.999999999993 in doubles
  x3.factor = 0.0002;
  x3.offset = -1.0;
  x3.minimum = -1.0;
  x3.maximum = 12.107;
  Bytes data{};
  EXPECT_TRUE(Encode(x3, 12.107, data));
  EXPECT_EQ(ExtractRaw(x3, data), 65535);
}

TEST(Codec, NanWritesTheMinimum) {
  Signal signal = Intel(0, 16);
  signal.factor = 0.01;
  signal.offset = -50.0;
  signal.minimum = -20.0;
  signal.maximum = 100.0;
  Bytes data{0xFF, 0xFF};
  EXPECT_FALSE(Encode(signal, kNan, data));
  EXPECT_DOUBLE_EQ(Decode(signal, data), -20.0);
  signal.factor = -0.01;  // the smallest physical value is the largest raw value
  signal.offset = 200.0;
  EXPECT_FALSE(Encode(signal, kNan, data));
  EXPECT_DOUBLE_EQ(Decode(signal, data), -20.0);
  EXPECT_FALSE(Encode(Intel(0, 16, true), kNan, data));
  EXPECT_EQ(ExtractRaw(Intel(0, 16, true), data), -32768);
}

TEST(Codec, ExtremeValuesSaturateInEveryLength) {
  for (int length = 1; length <= 64; ++length) {
    for (const double extreme : {kInfinity, 1e308, 0x1p64, 0x1p63}) {
      Bytes data{};
      Encode(Intel(0, length), extreme, data);
      const auto all = std::numeric_limits<std::uint64_t>::max() >> (64U - static_cast<unsigned>(length));
      const auto expected = length == 64 && extreme == 0x1p63 ? std::uint64_t{1} << 63U : all;
      EXPECT_EQ(static_cast<std::uint64_t>(ExtractRaw(Intel(0, length), data)), expected) << length;
      Encode(Intel(0, length, true), extreme, data);
      EXPECT_EQ(ExtractRaw(Intel(0, length, true), data), static_cast<std::int64_t>(all >> 1U)) << length;
      Encode(Intel(0, length, true), -extreme, data);
      EXPECT_EQ(ExtractRaw(Intel(0, length, true), data), -static_cast<std::int64_t>(all >> 1U) - 1)
          << length;
    }
  }
}

Signal Float(ValueType type, Signal at) {
  at.type = type;
  return at;
}

TEST(Codec, FloatsAreTheBitsOfIeee754) {
  // -1.5 is BFC00000, 0.1 is 3FB999999999999A; Motorola writes the most significant byte first.
  Bytes data{0x00, 0x00, 0xC0, 0xBF};
  EXPECT_EQ(Decode(Float(ValueType::kFloat32, Intel(0, 32)), data), -1.5);
  EXPECT_EQ(Decode(Float(ValueType::kFloat32, Intel(0, 32, true)), data), -1.5);
  EXPECT_TRUE(Encode(Float(ValueType::kFloat64, Motorola(7, 64)), 0.1, data));
  EXPECT_EQ(data, (Bytes{0x3F, 0xB9, 0x99, 0x99, 0x99, 0x99, 0x99, 0x9A}));
  EXPECT_EQ(Decode(Float(ValueType::kFloat64, Motorola(7, 64)), data), 0.1);
}

TEST(Codec, FloatsHaveFactorOffsetAndRange) {
  Signal signal = Float(ValueType::kFloat32, Intel(0, 32));
  signal.factor = 0.5;
  signal.offset = 10.0;
  signal.minimum = -20.0;
  signal.maximum = 20.0;
  Bytes data{};
  EXPECT_TRUE(Encode(signal, 12.25, data));
  EXPECT_EQ(data, (Bytes{0x00, 0x00, 0x90, 0x40}));  // 4.5
  EXPECT_EQ(Decode(signal, data), 12.25);
  EXPECT_FALSE(Encode(signal, 21.0, data));
  EXPECT_EQ(Decode(signal, data), 20.0);
  EXPECT_FALSE(Encode(signal, -kInfinity, data));
  EXPECT_EQ(Decode(signal, data), -20.0);
}

TEST(Codec, FloatsWithoutRangeSaturateAtTheLargestNumberAndKeepNan) {
  const Signal signal = Float(ValueType::kFloat32, Intel(0, 32));
  Bytes data{};
  EXPECT_FALSE(Encode(signal, 1e39, data));
  EXPECT_EQ(Decode(signal, data), double{std::numeric_limits<float>::max()});
  EXPECT_FALSE(Encode(signal, kNan, data));
  EXPECT_TRUE(std::isnan(Decode(signal, data)));
}

TEST(Codec, TellsWhichRawValuesADoubleHolds) {
  const Signal wide = Intel(0, 64);
  const Signal negative = Intel(0, 64, true);
  const std::int64_t exact = std::int64_t{1} << 53;
  EXPECT_TRUE(IsExact(wide, 0));
  EXPECT_TRUE(IsExact(wide, exact));
  EXPECT_FALSE(IsExact(wide, exact + 1));
  EXPECT_TRUE(IsExact(wide, exact + 2));
  EXPECT_FALSE(IsExact(wide, -1));  // 2^64 - 1
  EXPECT_TRUE(IsExact(negative, -1));
  EXPECT_TRUE(IsExact(negative, std::numeric_limits<std::int64_t>::min()));
  EXPECT_FALSE(IsExact(negative, std::numeric_limits<std::int64_t>::min() + 1));
  EXPECT_TRUE(IsExact(Float(ValueType::kFloat64, wide), -1));
}

RC_GTEST_PROP(CodecProperty, ExactValuesAreThoseThatComeBack, ()) {
  const auto raw = *rc::gen::arbitrary<std::int64_t>() / (std::int64_t{1} << *rc::gen::inRange(0, 20));
  const Signal wide = Intel(0, 64, true);
  const auto there = static_cast<double>(raw);
  RC_PRE(there < 0x1p63);
  RC_ASSERT(IsExact(wide, raw) == (static_cast<std::int64_t>(there) == raw));
}

TEST(Codec, ASelectedSignalIsThereWhileTheSelectorSaysSo) {
  Message message;
  message.signals = {Intel(0, 4), Intel(8, 8), Intel(8, 16), Intel(4, 4)};
  message.signals[0].multiplexing = Multiplexing::kSelector;
  message.signals[1].multiplexing = Multiplexing::kSelected;
  message.signals[1].selected_by = 2;
  message.signals[2].multiplexing = Multiplexing::kSelected;
  message.signals[2].selected_by = 3;
  const Bytes two{0xF2};
  const Bytes nothing{0xF0};
  const auto carried = [&](const Bytes& data) {
    std::vector<bool> answers;
    for (const Signal& signal : message.signals) answers.push_back(Carries(message, signal, data));
    return answers;
  };
  EXPECT_EQ(carried(two), (std::vector{true, true, false, true}));
  EXPECT_EQ(carried(nothing), (std::vector{true, false, false, true}));
}

/// A signal of any length that lies inside 64 bytes, in any byte order.
rc::Gen<Signal> AnySignal() {
  return rc::gen::exec([] {
    Signal signal;
    signal.little_endian = *rc::gen::arbitrary<bool>();
    signal.is_signed = *rc::gen::arbitrary<bool>();
    signal.length_bits = *rc::gen::inRange(1, 65);
    const int first = *rc::gen::inRange(0, 512 - signal.length_bits + 1);  // counted from the MSB of byte 0
    signal.start_bit = signal.little_endian ? first : first / 8 * 8 + 7 - first % 8;
    return signal;
  });
}

RC_GTEST_PROP(CodecProperty, WhatIsInsertedIsExtractedAndOtherBitsStay, ()) {
  const Signal signal = *AnySignal();
  const auto raw = *rc::gen::arbitrary<std::int64_t>();
  auto data = *rc::gen::container<std::vector<std::uint8_t>>(64, rc::gen::arbitrary<std::uint8_t>());
  const auto before = data;
  InsertRaw(signal, raw, data);
  const auto keep = 64U - static_cast<unsigned>(signal.length_bits);
  const auto shifted = static_cast<std::uint64_t>(raw) << keep;
  RC_ASSERT(ExtractRaw(signal, data) == (signal.is_signed ? static_cast<std::int64_t>(shifted) >> keep
                                                          : static_cast<std::int64_t>(shifted >> keep)));
  InsertRaw(signal, ExtractRaw(signal, before), data);
  RC_ASSERT(data == before);
}

RC_GTEST_PROP(CodecProperty, EncodeErrsByAtMostHalfAStep, ()) {
  Signal signal = *AnySignal();
  signal.length_bits = std::min(signal.length_bits, 45);  // doubles resolve a hundredth of a step
  signal.factor = *rc::gen::element(1.0, -1.0, 0.25, 0.001, -0.3, 100.0);
  signal.offset = *rc::gen::element(0.0, -40.0, 1e3);
  std::vector<std::uint8_t> data(64);
  InsertRaw(signal, *rc::gen::arbitrary<std::int64_t>(), data);
  const double on_grid = Decode(signal, data);
  const double physical = on_grid + signal.factor * 0.001 * *rc::gen::inRange(-450, 451);
  const bool inside = Encode(signal, physical, data);
  const double error = std::abs(Decode(signal, data) - physical);
  // At most 0.45 steps away; each of three roundings of up to 2^46 steps errs by at most 2^-7 steps.
  RC_ASSERT(inside);
  RC_ASSERT(error <= std::abs(signal.factor) * 0.5 + std::abs(physical) * 0x1p-50);
}

// What was meant is what encoding would write: the stated ends are inside for every factor and offset, one
// step beyond them is outside.
TEST(Codec, TheEndsOfAStatedRangeAreInside) {
  for (const double factor : {0.1, 0.001, 0.03, 1.0 / 3.0, -0.1, 2.5, 1e-7}) {
    for (const double offset : {0.0, -40.0, 12.107}) {
      for (const int raw : {1, 41, 3, 1000, 65533}) {
        Signal signal = Intel(0, 16);
        signal.factor = factor;
        signal.offset = offset;
        std::array<char, 40> text{};
        std::snprintf(text.data(), text.size(), "%.9g", raw * factor + offset);  // as a person writes it
        const double end = std::strtod(text.data(), nullptr);
        if (std::fabs(end - (raw * factor + offset)) > 1e-7 * std::fabs(factor))
          continue;  // rounded by 9 digits
        signal.minimum = std::min(offset, end);
        signal.maximum = std::max(offset, end);
        SCOPED_TRACE(testing::Message() << factor << " " << offset << " " << raw);
        EXPECT_TRUE(IsInStatedRange(signal, raw));
        EXPECT_TRUE(IsInStatedRange(signal, 0));
        EXPECT_FALSE(IsInStatedRange(signal, raw + 1));
      }
    }
  }
}

TEST(Codec, AFloatNextToAStatedEndIsTheEnd) {
  Signal signal = Intel(0, 32);
  signal.type = ValueType::kFloat32;
  signal.minimum = 0.1;
  signal.maximum = 4.1;
  const auto bits = [](float value) { return std::int64_t{std::bit_cast<std::int32_t>(value)}; };
  EXPECT_TRUE(IsInStatedRange(signal, bits(4.1F)));  // 4.099999904
  EXPECT_TRUE(IsInStatedRange(signal, bits(0.1F)));  // 0.100000001
  signal.maximum = 20.7;
  EXPECT_TRUE(IsInStatedRange(signal, bits(20.7F)));                         // 20.70000076
  EXPECT_TRUE(IsInStatedRange(signal, bits(std::nextafter(20.7F, 30.0F))));  // 100.0F * 0.207F
  EXPECT_FALSE(IsInStatedRange(signal, bits(20.70002F)));
  EXPECT_FALSE(IsInStatedRange(signal, bits(std::numeric_limits<float>::quiet_NaN())));
  EXPECT_FALSE(IsInStatedRange(signal, bits(std::numeric_limits<float>::infinity())));
}

TEST(Codec, ANumberIsFoundInAFieldByItsBits) {
  EXPECT_EQ(RawInField(Intel(0, 1, true), 1), -1);
  EXPECT_EQ(RawInField(Intel(0, 1, true), 0), 0);
  EXPECT_EQ(RawInField(Intel(0, 1, true), 2), std::nullopt);
  EXPECT_EQ(RawInField(Intel(0, 8), -1), 255);
  EXPECT_EQ(RawInField(Intel(0, 8), -129), std::nullopt);
  EXPECT_EQ(RawInField(Intel(0, 8), 256), std::nullopt);
  EXPECT_EQ(RawInField(Intel(0, 8, true), 255), -1);
  EXPECT_EQ(RawInField(Intel(0, 8, true), 127), 127);
  EXPECT_EQ(RawInField(Motorola(7, 64, true), -7), -7);
  Signal trip = Intel(0, 1, true);
  trip.value_names = {{0, "normal"}, {1, "tripped"}};
  EXPECT_EQ(NameOfRaw(trip, -1), "tripped");
  EXPECT_EQ(NameOfRaw(trip, 0), "normal");
}

// SAE J1939-71, 5.1.5.
TEST(Codec, J1939SetsValuesAside) {
  using J = J1939Value;
  const auto of = [](int length, std::int64_t raw) { return J1939ValueOf(Intel(0, length), raw); };
  EXPECT_EQ(of(1, 1), J::kValid);
  EXPECT_EQ(of(2, 1), J::kValid);
  EXPECT_EQ(of(2, 2), J::kError);
  EXPECT_EQ(of(2, 3), J::kNotAvailable);
  EXPECT_EQ(of(4, 13), J::kValid);
  EXPECT_EQ(of(4, 14), J::kError);
  EXPECT_EQ(of(8, 0xFA), J::kValid);
  EXPECT_EQ(of(8, 0xFB), J::kReserved);
  EXPECT_EQ(of(8, 0xFE), J::kError);
  EXPECT_EQ(of(8, 0xFF), J::kNotAvailable);
  EXPECT_EQ(of(16, 0xFAFF), J::kValid);
  EXPECT_EQ(of(16, 0xFDFF), J::kReserved);
  EXPECT_EQ(of(16, 0xFE12), J::kError);
  EXPECT_EQ(of(16, 0xFF00), J::kNotAvailable);
  EXPECT_EQ(of(32, 0xFAFF'FFFF), J::kValid);
  EXPECT_EQ(of(32, 0xFFFF'FFFF), J::kNotAvailable);
  EXPECT_EQ(of(64, -1), J::kNotAvailable);
  EXPECT_EQ(J1939ValueOf(Intel(0, 8, true), -1), J::kValid);
}

}  // namespace
}  // namespace servohil::can
