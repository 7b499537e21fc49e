#pragma once
/// What the catalogue's faults of the model have in common. Nothing of a fault, share 0, changes nothing, to
/// the last bit; faults that add up stay within what a configuration may hold (app/key_table.cpp).

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fault/catalogue.hpp"

namespace servohil::fault {

using P = model::Parameters;
using V = Values;

/// From `is` to `becomes` as far as `share` says; `is` itself, to the last bit, at 0.
inline double Toward(double is, double becomes, double share) noexcept {
  return is + share * (becomes - is);
}

inline double Sine(double amplitude, double frequency_hz, double t_s) noexcept {
  return amplitude * std::sin(2.0 * std::numbers::pi * frequency_hz * t_s);
}

/// A passage's area, lost but for a pinhole that the smallest diameter of a configuration has.
inline void Plug(double& diameter_in, double area_lost) noexcept {
  constexpr double kPinholeIn = 1e-3;
  diameter_in = std::max(std::min(diameter_in, kPinholeIn), diameter_in * std::sqrt(1.0 - area_lost));
}
/// Loses a share of itself, but not all.
inline void Lose(double& value, double lost, double least) noexcept {
  value = std::max(std::min(value, least), value * (1.0 - lost));
}
inline void AddTo(double& value, double more, double low, double high) noexcept {
  value = std::clamp(value + more, std::min(value, low), std::max(value, high));
}

}  // namespace servohil::fault
