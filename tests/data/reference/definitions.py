"""What is computed: the golden cases and the verdict table. Standard library only, so that the
end-to-end tests can use it where scipy is not installed.

A configuration is a dictionary of servohil configuration keys, exactly as passed to `--set`.
"""

import math

TICK_S = 1e-4

# --- configurations ------------------------------------------------------------------------------
NO_CLEARANCE = {"servo.relay_piston_clearance_in": 0.0, "servo.relay_plunger_clearance_in": 0.0}
SMALL_UNDERLAP = {"servo.underlap_in": 0.001, **NO_CLEARANCE}  # the unstable set of Figures 22, 23
TWO_SLOPE = {"cam.shape": "two_slope"}


def clearance(inch):
    return dict.fromkeys(NO_CLEARANCE, inch)


def underlap(inch):
    return {"servo.underlap_in": inch}


def bulk_modulus(psi):
    return {"servo.bulk_modulus_psi": float(psi)}


def supply(psi):
    return {"supply.pressure_psi": float(psi)}


def friction(psi):
    return {"friction.coulomb_psi": float(psi)}


def stabilizer(d7, l7, va):
    """A row of Table VII; oil volume = gas volume, as in section 5.4."""
    return {"stabilizer.enabled": True, "stabilizer.capillary_diameter_in": d7,
            "stabilizer.capillary_length_in": l7, "stabilizer.oil_volume_in3": float(va),
            "stabilizer.gas_volume_in3": float(va)}


TABLE_VII = {1: stabilizer(0.10, 8.2, 98), 2: stabilizer(0.15, 7.5, 98), 3: stabilizer(0.14, 12.0, 20),
             4: stabilizer(0.30, 15.0, 100), 5: stabilizer(0.30, 15.0, 20)}


# --- control pressure ----------------------------------------------------------------------------
def step(delta_psi):
    """Steady-state P1 + delta from t = 0 on: `--p1-step`."""
    return {"kind": "step", "delta_psi": float(delta_psi)}


def table(*rows):
    """Rows (t s, p1 psi), each held until the next: `--p1-file`."""
    return {"kind": "table", "rows": [list(r) for r in rows]}


def sine(mean_psi, amplitude_psi, frequency_hz):
    return {"kind": "sine", "mean_psi": mean_psi, "amplitude_psi": amplitude_psi, "frequency_hz": frequency_hz}


def ramp(from_psi, rate_psi_s):
    return {"kind": "ramp", "from_psi": from_psi, "rate_psi_s": rate_psi_s}


def p1_rows(p1, duration_s):
    """[(tick, p1 psi)] of a table, sine or ramp: held from that tick on, six decimals, repeats left out.

    The six decimals are what goes into the CSV file, so both programs see the same number.
    """
    if p1["kind"] == "table":
        return [(round(t / TICK_S), float(p)) for t, p in p1["rows"]]
    if p1["kind"] == "sine":
        def value(t):
            return p1["mean_psi"] + p1["amplitude_psi"] * math.sin(2 * math.pi * p1["frequency_hz"] * t)
    else:
        def value(t):
            return p1["from_psi"] + p1["rate_psi_s"] * t
    rows = []
    for n in range(round(duration_s / TICK_S)):
        p = round(value(n * TICK_S), 6)
        if not rows or rows[-1][1] != p:
            rows.append((n, p))
    return rows


# --- golden cases --------------------------------------------------------------------------------
def case(name, about, x3_in, p1, *overrides, duration_s=0.5):
    merged = {}
    for o in overrides:
        merged.update(o)
    return {"name": name, "about": about, "start_x3_in": x3_in, "p1": p1, "duration_s": duration_s, "set": merged}


def sample_ticks(duration_s):
    """Every 5 ms to 0.1 s, every 10 ms after: 61 for 0.5 s."""
    end = round(duration_s / TICK_S)
    return list(range(0, 1000, 50)) + list(range(1000, end + 1, 100))


CASES = [
    # single-slope cam
    case("single-up2-low", "3.35->3.40 jump upwards, nominal parameters", 3.2, step(2)),
    case("single-down2-low", "3.40->3.35 jump downwards", 4.0, step(-2), bulk_modulus(230e3)),
    case("single-down5-low-r4", "3.40->3.35 downwards, far; recommended stabilizer", 4.0, step(-5), TABLE_VII[4]),
    case("single-up5-high", "6.25->6.30 jump upwards, large underlap", 5.6, step(5), underlap(0.004), bulk_modulus(150e3)),
    case("single-up5-high-r4", "the same with the recommended stabilizer", 5.6, step(5), TABLE_VII[4]),
    case("single-up5-high-p250", "low supply, large clearances", 5.6, step(5), supply(250), clearance(0.003)),
    case("single-down5-high", "6.30->6.25 jump downwards, nominal parameters", 7.2, step(-5)),
    case("single-down5-high-r5", "the same with Table VII row 5", 7.2, step(-5), TABLE_VII[5]),
    case("single-down2-high", "comes to rest just above 6.30", 7.2, step(-2), clearance(0.001), underlap(0.003), bulk_modulus(170e3)),
    case("single-up2-r3", "Table VII row 3", 4.6, step(2), TABLE_VII[3]),
    case("single-up2-r1", "Table VII row 1, nominal clearances", 4.0, step(2), TABLE_VII[1]),
    case("single-up2-end", "beyond the last load point, 8.00 in: extrapolated", 7.4, step(2), TABLE_VII[4]),
    # two-slope cam (Curve A, kink at 2.8444 in)
    case("two-up5-kink-r4", "cam kink and low jump upwards", 2.6, step(5), TWO_SLOPE, TABLE_VII[4]),
    case("two-down5-kink", "low jump and cam kink downwards", 3.8, step(-5), TWO_SLOPE),
    case("two-up2-high-r5", "high jump upwards, Table VII row 5", 6.0, step(2), TWO_SLOPE, TABLE_VII[5]),
    case("two-down5-high-r2", "high jump downwards, Table VII row 2", 6.8, step(-5), TWO_SLOPE, TABLE_VII[2]),
    case("two-down2-high", "high jump downwards", 6.8, step(-2), TWO_SLOPE, bulk_modulus(230e3)),
    case("two-down2-end-r4", "below the first load point, 1.00 in: extrapolated", 1.2, step(-2), TWO_SLOPE, TABLE_VII[4]),
    # Coulomb friction
    case("single-down2-low-b5", "friction 5 psi, low jump downwards", 4.0, step(-2), friction(5)),
    case("single-up2-low-b5", "friction 5 psi stops the unstable set: some fifty stick phases", 3.0, step(2), SMALL_UNDERLAP, friction(5)),
    case("single-up5-high-b5-p350", "friction 5 psi, high supply", 5.6, step(5), supply(350), friction(5)),
    case("single-down5-high-b10", "friction 10 psi, high jump downwards", 7.2, step(-5), friction(10)),
    case("two-down5-kink-b10", "friction 10 psi, low jump and kink downwards", 3.8, step(-5), TWO_SLOPE, friction(10)),
    # reversals: control pressure as a table, steady P1 at the start +- a few psi
    case("two-pulse-b5", "up and back over the high jump: stick phases of 2 ms on the way", 6.0,
         table((0, 46.15), (0.25, 44.15)), TWO_SLOPE, friction(5)),
    case("single-pulse-b5", "up, down, half up: both directions over the low jump", 3.6,
         table((0, 31.3), (0.2, 28.3), (0.35, 29.8)), friction(5)),
    case("single-pulse-b10-r4", "down, then up; comes to rest held by friction", 4.2,
         table((0, 28.7), (0.25, 32.7)), friction(10), TABLE_VII[4]),
    # zero-order hold, one value per tick
    case("single-sine-b10", "small slow sine: stick-slip at every reversal", 4.4, sine(31.2, 0.15, 2.0), friction(10), duration_s=1.0),
    case("single-sine-b5", "fast sine on the unstable set: reversals and short stick phases", 5.5, sine(33.77, 0.3, 10.0), SMALL_UNDERLAP, friction(5)),
    case("single-ramp-b10", "slow ramp: held at first, then up the low jump", 3.2, ramp(28.39, 1.5), friction(10)),
]

# --- verdicts ------------------------------------------------------------------------------------
# Small step of the thesis: 0.27 psi from the steady state at 4.0 in, 1 s.
LIMIT_CYCLE_IN_S = 1.0      # every limit cycle of the tables swings more than 2 in/s
VERDICT_X3_IN, VERDICT_STEP_PSI, VERDICT_S = 4.0, 0.27, 1.0
AT_REST_SWING_IN_S = 1e-3  # the step itself swings 6 in/s; held by friction the piston creeps below 1e-8 in/s


def _verdict(name, stated, about, *overrides):
    merged = {}
    for o in overrides:
        merged.update(o)
    return {"name": name, "stated": stated, "about": about, "set": merged}


VERDICTS = [
    _verdict("IV-1", "stable", "Figures 14 to 17", underlap(0.002), NO_CLEARANCE, bulk_modulus(230e3)),
    _verdict("IV-2", "unstable", "Figure 18; printed 'Stable', true in its 0.1 s only (errata 19)", SMALL_UNDERLAP, bulk_modulus(230e3)),
    _verdict("IV-3", "stable", "Figures 19 to 21", underlap(0.002), clearance(0.002), bulk_modulus(110e3)),
    _verdict("IV-4", "unstable", "Figures 22, 23", SMALL_UNDERLAP, bulk_modulus(110e3)),
    _verdict("IV-5", "stable", "Figures 24, 25: oscillatory", underlap(0.002), clearance(0.002), bulk_modulus(90e3)),
    _verdict("IV-6", "stable", "Figures 26 to 28: IV-4 with friction", SMALL_UNDERLAP, bulk_modulus(110e3), friction(5)),
    _verdict("IV-7", "stable", "Figures 29 to 31: alpha 0.45 with friction", underlap(0.002), clearance(0.002), bulk_modulus(110e3),
             {"cam.alpha": 0.45}, friction(5)),
    _verdict("IV-7 without friction", "unstable", "sentence after Table IV", underlap(0.002), clearance(0.002), bulk_modulus(110e3),
             {"cam.alpha": 0.45}),
    *(_verdict(f"VII-{row}", "unstable" if row == 1 else "stable", f"Table VII row {row}",
               SMALL_UNDERLAP, bulk_modulus(110e3), TABLE_VII[row]) for row in TABLE_VII),
]


def swing(t, y, t_from, t_to):
    """Peak-to-peak of y in [t_from, t_to]."""
    window = [b for a, b in zip(t, y) if t_from - 1e-9 <= a <= t_to + 1e-9]
    return max(window) - min(window)


def verdict(t, v3):
    """Stability of a 1 s response, from the peak-to-peak swing of the velocity v3.

    early: swing in 0.1 .. 0.2 s, when the response to the step itself is over.
    late:  swing in 0.9 .. 1.0 s.

    stable    late < 0.1 early, or late < 1e-3 in/s: decays, or is at rest (friction)
    unstable  late > 0.5 early and late > 1 in/s: grows, or stays as a limit cycle
    None      neither: the criterion does not decide
    """
    early, late = swing(t, v3, 0.1, 0.2), swing(t, v3, 0.9, 1.0)
    if late > 0.5 * early and late > LIMIT_CYCLE_IN_S:
        return "unstable"
    if late < max(0.1 * early, AT_REST_SWING_IN_S):
        return "stable"
    return None


# --- held by friction ----------------------------------------------------------------------------
# How far P1 may move from the steady state before the piston breaks away: the valve's pressure gain
# is large, so 10 psi of friction hold only against some 0.0015 psi of control pressure.
# [psi], from `generate.py --dead-band`: (x3 in, overrides, P1 at the steady state, down, up).
HELD = [
    (4.0, friction(10), 30.26319757, -0.00155887, +0.00144189),
    (2.0, friction(5), 25.57615228, -0.00261612, +0.00189524),
    (7.0, {**TWO_SLOPE, **friction(5)}, 47.43479567, -0.00069479, 0.00067765),
]
BREAKAWAY_STEP_PSI = 0.003   # about twice what HELD[0] holds
BREAKAWAY_REST_IN = 4.00066834  # where it comes to rest again: friction carries its full 10 psi there
