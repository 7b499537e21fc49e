#include "model/envelope_sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "model/step.hpp"

namespace servohil::model {
namespace {

constexpr int kFiner = 8;
constexpr int kWantedCompared = 8;  // sub-steps; below, RK4 is far inside its bound
// Bound the time, 50 ms where all is stiff. 30 ms take the nominal piston from 2 in into its stop at 70 in/s.
constexpr int kMaxCompared = 150;
constexpr int kTicksOfJump = 300;
constexpr int kTicksTowardRest = 40;
constexpr std::array kStarts = {0.005, 0.25, 0.75, 0.995};  // of the stroke

SweepTick TickFrom(const Derived& d, const State& s, double p1_psi) noexcept {
  const TimeScales t = RatesAndScalesAt(d, s, p1_psi).scales;
  struct Wish {
    Fastest what;
    double rate_1_s;
    double per_sub_step;
  };
  const Wish wishes[] = {{Fastest::kRelayChamber, t.relay_mode, kRateTimesSubStep},
                         {Fastest::kPistonChamber, t.piston_mode, kRateTimesSubStep},
                         {Fastest::kOilStiffness, t.stiffness, kStiffnessShare},
                         {Fastest::kMeteringPorts, t.ports, 1.0}};
  SweepTick tick{.state = s, .p1_psi = p1_psi};
  for (const Wish& wish : wishes) {
    const double wanted = kTickS * wish.rate_1_s / wish.per_sub_step;
    if (!(wanted <= tick.wanted)) tick = {s, p1_psi, wanted, wish.what, wish.rate_1_s};
  }
  return tick;
}

double PressureDistance(const Derived& d, const State& a, const State& b) noexcept {
  const double chambers = std::fmax(std::fabs(a.p3_psi - b.p3_psi), std::fabs(a.p4_psi - b.p4_psi));
  return d.stabilizer ? std::fmax(chambers, std::fabs(a.p8_psi - b.p8_psi)) : chambers;
}

class Sweep {
 public:
  explicit Sweep(const Derived& d) noexcept : d_(d) {}

  void Run(State& s, double p1_psi, int ticks) noexcept {
    for (int i = 0; i < ticks && !result_.left_domain; ++i) Tick(s, p1_psi);
  }
  const EnvelopeSweep& Result() const noexcept { return result_; }

 private:
  void Tick(State& s, double p1_psi) noexcept {
    const State before = s;
    const StepResult next = Step(d_, before, p1_psi);
    ++result_.ticks;
    if (!next.resolved) ++result_.unresolved_ticks;
    if (!IsInDomain(d_, next.state)) {
      result_.left_domain = true;
      result_.worst = TickFrom(d_, before, p1_psi);
      return;
    }
    s = next.state;
    if (!next.resolved || next.sub_steps > kWantedCompared) Compare(before, p1_psi, next.state);
  }

  void Compare(const State& before, double p1_psi, const State& after) noexcept {
    SweepTick tick = TickFrom(d_, before, p1_psi);
    if (compared_++ >= kMaxCompared) {
      Note(tick);
      return;
    }
    State fine = before;
    for (int i = 0; i < kFiner; ++i) {
      fine = Step(d_, fine, p1_psi, kTickS / kFiner).state;
      const SweepTick later = TickFrom(d_, fine, p1_psi);
      if (later.wanted > tick.wanted) tick = later;
    }
    Note(tick);
    const double pressure_error_psi = PressureDistance(d_, after, fine);
    result_.x3_error_in += std::fabs(after.x3_in - fine.x3_in);
    if (pressure_error_psi <= result_.pressure_error_psi) return;
    result_.pressure_error_psi = pressure_error_psi;
    result_.worst = tick;
  }

  void Note(const SweepTick& tick) noexcept {
    if (tick.wanted > result_.most.wanted) result_.most = tick;
  }

  const Derived& d_;
  EnvelopeSweep result_;
  int compared_ = 0;
};

}  // namespace

EnvelopeSweep SweepEnvelope(const Derived& d) noexcept {
  Sweep sweep(d);
  for (const double share : kStarts) {
    const SteadyState start = SteadyStateAt(d, share * d.stroke_in);
    if (!start) continue;
    for (const auto& [first_psi, second_psi] :
         {std::pair{kLowestP1Psi, kHighestP1Psi}, {kHighestP1Psi, kLowestP1Psi}}) {
      State s = start.state;
      sweep.Run(s, first_psi, kTicksOfJump);
      sweep.Run(s, second_psi, kTicksOfJump);
      sweep.Run(s, start.p1_psi, kTicksTowardRest);
    }
  }
  return sweep.Result();
}

}  // namespace servohil::model
