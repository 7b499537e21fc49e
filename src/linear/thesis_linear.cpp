#include "linear/thesis_linear.hpp"

#include <cmath>

// NOLINTBEGIN(readability-identifier-naming): the symbols of the thesis

namespace servohil::linear {

ThesisCoefficients ThesisCoefficientsAt(const model::Parameters& p, const model::Derived& d,
                                        const model::SteadyState& point,
                                        const ThesisLinearOptions& options) noexcept {
  const model::Outputs& o = point.outputs;
  const double P3 = point.state.p3_psi;
  const double P4 = point.state.p4_psi;
  ThesisCoefficients c{};
  c.k3 = options.k3_lbf_in;
  c.v3_over_beta = options.v3_in3 / p.servo.bulk_modulus_psi;
  c.M = d.M;
  c.alpha = d.cam.SlopeAt(point.state.x3_in);
  c.A1 = d.A1;
  c.A2 = d.A2;
  c.A3 = d.A3;
  c.k1 = d.k1;
  c.k2 = d.k2;
  c.c3 = d.c3;
  c.C = options.simulation ? d.C : 0.0;
  c.V4_over_beta = options.simulation ? p.servo.relay_volume_in3 / p.servo.bulk_modulus_psi : 0.0;

  c.a1 = d.k_metering * std::sqrt(d.P2 - P3);                                      // (3.5)
  c.a2 = d.k_metering * std::sqrt(P3);                                             // (3.6)
  c.a3 = d.k_relay * std::sqrt(P4);                                                // (3.4)
  c.b1 = d.k_metering * (o.x2_in - o.x4_in + d.U) / (2.0 * std::sqrt(d.P2 - P3));  // (3.5)
  c.b2 = d.k_metering * (o.x4_in - o.x2_in + d.U) / (2.0 * std::sqrt(P3));         // (3.6)
  c.b3 = d.k_relay * (o.x2_in - o.x1_in) / (2.0 * std::sqrt(P4));                  // (3.4)
  c.a4 = d.capillary_a;                                                            // Appendix B
  if (options.full_a4) c.a4 *= 1.0 + 2.0 * d.capillary_b * o.q4_in3_s;             // (3.16)

  c.B1 = c.k2 / c.A2 * (1.0 / c.a4 + c.b3);
  c.B2 = c.c3 + c.b1 + c.b2;
  c.B3 = c.v3_over_beta / c.A3;
  c.B4 = c.B1 + c.a3;
  c.B5 = c.B3 * c.k3 + c.A3;
  c.B6 = c.k3 * c.B2 / c.A3 + (c.a1 + c.a2) * c.alpha;

  c.stabilizer = d.stabilizer;
  c.a5 = d.stabilizer ? 1.0 / d.R7 : 0.0;
  c.C8 = p.stabilizer.gas_volume_in3 / (p.stabilizer.polytropic_index * P3);  // V8/beta left out, section 5.4
  c.B7 = c.stabilizer ? c.C8 / c.a5 : 0.0;
  c.B8 = c.B2 * c.B7 + c.a5 * c.B7 + c.v3_over_beta;
  return c;
}

TransferFunction ThesisTransferFunction(const ThesisCoefficients& c) noexcept {
  const double K = c.a3 * c.A1 / c.k1 * (c.a1 + c.a2);
  const double C5 = c.B1 * c.alpha * (c.a1 + c.a2);
  if (!c.stabilizer) {
    return {{K},
            {c.A2 * c.B3 * c.M, c.B3 * c.B4 * c.M + c.A2 * c.B2 * c.M / c.A3,
             c.B2 * c.B4 * c.M / c.A3 + c.A2 * c.B5, c.B4 * c.B5 + c.A2 * c.B6, c.B4 * c.B6 - C5}};
  }
  const double C2 = c.B2 * c.M / c.A3 + c.A3 * c.B7 + c.B3 * c.k3 * c.B7;
  const double C3 = c.k3 * c.B8 / c.A3 + (c.a1 + c.a2) * c.alpha * c.B7 + c.A3;
  return {{K * c.B7, K},
          {c.A2 * c.B3 * c.B7 * c.M, c.B3 * c.B7 * c.B4 * c.M + c.A2 * c.B8 * c.M / c.A3,
           c.B4 * c.B8 * c.M / c.A3 + c.A2 * C2, c.B4 * C2 + c.A2 * C3, c.B4 * C3 + c.A2 * c.B6 - C5 * c.B7,
           c.B4 * c.B6 - C5}};
}

LinearSystem ThesisSystem(const ThesisCoefficients& c) noexcept {
  const int n = c.stabilizer ? 5 : 4;
  const double relay = c.V4_over_beta + c.A2 * c.A2 / c.k2;
  LinearSystem s{LinearMatrix::Zero(n, n), LinearVector::Zero(n)};
  s.A(model::kX3, model::kV3) = 1.0;
  s.A(model::kV3, model::kX3) = -c.k3 / c.M;  // (3.13)
  s.A(model::kV3, model::kV3) = -c.C / c.M;
  s.A(model::kV3, model::kP3) = c.A3 / c.M;
  s.A(model::kP3, model::kV3) = -c.A3 / c.v3_over_beta;  // (3.14)
  s.A(model::kP3, model::kP3) = -(c.B2 + c.a5) / c.v3_over_beta;
  s.A(model::kP3, model::kP4) = c.A2 / c.k2 * (c.a1 + c.a2) / c.v3_over_beta;
  s.A(model::kP4, model::kX3) = -c.a3 * c.alpha / relay;  // (3.15)
  s.A(model::kP4, model::kV3) = -c.A2 * c.alpha / relay;
  s.A(model::kP4, model::kP4) = -(c.a3 * c.A2 / c.k2 + c.b3 + 1.0 / c.a4) / relay;
  s.B[model::kP4] = c.a3 * c.A1 / c.k1 / relay;
  if (c.stabilizer) {
    s.A(model::kP3, model::kP8) = c.a5 / c.v3_over_beta;  // (G.5) with (G.11)
    s.A(model::kP8, model::kP3) = 1.0 / c.B7;             // (G.12)
    s.A(model::kP8, model::kP8) = -1.0 / c.B7;
  }
  return s;
}

}  // namespace servohil::linear

// NOLINTEND(readability-identifier-naming)
