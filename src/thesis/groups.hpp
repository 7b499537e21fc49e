#pragma once
/// The printed numbers, in the order of the source. Each function appends its groups.

#include "thesis/entry.hpp"

namespace servohil::thesis {

void AppendSteadyState(const MakeCase& make, Groups& groups);        ///< Appendix A, B, E, H; section 3.4
void AppendCoefficients(const MakeCase& make, Groups& groups);       ///< Appendix B
void AppendTransferFunctions(const MakeCase& make, Groups& groups);  ///< (3.18), (3.19), Section 5.4, Routh
void AppendLinearTables(const MakeCase& make, Groups& groups);       ///< Tables III, VI; Figure 6
void AppendStabilizerTables(const MakeCase& make, Groups& groups);   ///< (5.10), Tables V, VII: R, C, tau_p
void AppendSimulatedTables(const MakeCase& make, Groups& groups);    ///< Tables IV, VII: verdicts

}  // namespace servohil::thesis
