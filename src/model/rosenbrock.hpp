#pragma once
/// RODAS3, a linearly implicit Runge-Kutta (Rosenbrock) method of order 3 with 4 stages, L-stable and stiffly
/// accurate: Sandu, Verwer, Blom, Spee, Carmichael, Potra, "Benchmarking stiff ODE solvers for atmospheric
/// chemistry problems II: Rosenbrock solvers", Atmospheric Environment 31 (1997). For modes that no explicit
/// step resolves: it damps what is faster than the step, needs no iteration, takes the same time always, and
/// allocates nothing. Real-time safe if `f` is.

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

namespace servohil::model {

/// @param f  vector f(vector y): dy/dt, autonomous over the step
/// @param f0  f(y)
/// @param h  step [s]
/// @param scale  typical size of each component: the Jacobian's differences are 1e-7 of it or of the
/// component
template <typename Vector, typename Function>
Vector Rodas3(const Function& f, const Vector& y, const Vector& f0, double h, const Vector& scale) {
  constexpr int kSize = Vector::RowsAtCompileTime;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  constexpr double kGamma = 0.5;

  Matrix system;  // 1/(h gamma) I - J
  for (int j = 0; j < kSize; ++j) {
    const double step = 1e-7 * (scale[j] + std::fabs(y[j]));
    Vector shifted = y;
    shifted[j] += step;
    system.col(j) = (f0 - f(shifted)) / step;
    system(j, j) += 1.0 / (h * kGamma);
  }
  const Eigen::PartialPivLU<Matrix> lu(system);
  const Vector k1 = lu.solve(f0);
  const Vector k2 = lu.solve(Vector(f0 + (4.0 / h) * k1));
  const Vector f3 = f(Vector(y + 2.0 * k1));
  const Vector k3 = lu.solve(Vector(f3 + (1.0 / h) * (k1 - k2)));
  const Vector f4 = f(Vector(y + 2.0 * k1 + k3));
  const Vector k4 = lu.solve(Vector(f4 + (1.0 / h) * (k1 - k2 - (8.0 / 3.0) * k3)));
  return y + 2.0 * k1 + k3 + k4;
}

}  // namespace servohil::model
