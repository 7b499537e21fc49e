#pragma once
/// Classical fourth-order Runge-Kutta step (Kutta 1901), fixed step, no allocation:
///   local error O(h⁵), global O(h⁴); stable for real eigenvalues with h |lambda| < 2.785.
/// Real-time safe if `f` is.

namespace servohil::model {

/// @param f  vector f(vector y): dy/dt, autonomous over the step
/// @param h  step [s]
/// @param k1  f(y)
template <typename Vector, typename Function>
Vector RungeKutta4(const Function& f, const Vector& y, const Vector& k1, double h) {
  const Vector k2 = f(Vector(y + (0.5 * h) * k1));
  const Vector k3 = f(Vector(y + (0.5 * h) * k2));
  const Vector k4 = f(Vector(y + h * k3));
  return y + (h / 6.0) * (k1 + 2.0 * (k2 + k3) + k4);
}

template <typename Vector, typename Function>
Vector RungeKutta4(const Function& f, const Vector& y, double h) {
  return RungeKutta4<Vector>(f, y, f(y), h);
}

}  // namespace servohil::model
