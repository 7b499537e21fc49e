"""The scenarios of the envelope: what is computed and compared. Standard library only.

A configuration is a dictionary of servohil configuration keys, as passed to `--set`; `closing_curve`, rows of x3 and
P3, becomes the file of load.closing_file. P1 as in ../reference/definitions.py: a step from the steady state, or a
table of (t s, P1 psi), each held until the next.
"""

import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))

from definitions import (NO_CLEARANCE, TABLE_VII, TICK_S, TWO_SLOPE, bulk_modulus,  # noqa: E402
                         clearance, p1_rows, stabilizer, step, supply, table, underlap)
from servomotor import LOAD_P3_PSI, LOAD_X3_IN  # noqa: E402

__all__ = ["SCENARIOS", "TICK_S", "p1_rows", "sample_ticks"]

FULL = {"model.physics": "full"}
LIQUID_PSI = 230e3  # of MIL-H-5606 without air, MODEL.md "Oil with air"


def air(fraction, index=1.0, dissolution_psi=0.0):
    return {"oil.air_fraction": fraction, "oil.air_polytropic_index": index,
            "oil.dissolution_pressure_psi": dissolution_psi, **bulk_modulus(LIQUID_PSI)}


def oil(name, temperature_c):
    return {"oil.name": name, "oil.temperature_c": float(temperature_c)}


def friction(coulomb, breakaway=0.0, stribeck_in_s=0.1, viscous=0.0, closing_ratio=1.0):
    return {"friction.coulomb_psi": float(coulomb), "friction.breakaway_psi": float(breakaway),
            "friction.stribeck_velocity_in_s": stribeck_in_s, "friction.viscous_psi_s_in": viscous,
            "friction.closing_ratio": closing_ratio}


def pump(flow_in3_s, accumulator_in3, band_psi=10.0):
    return {"supply.pump_flow_in3_s": float(flow_in3_s), "supply.accumulator_volume_in3": float(accumulator_in3),
            "supply.pump_band_psi": band_psi}


def precharge(charge_psi, precharge_psi):
    return {"stabilizer.charge_pressure_psi": float(charge_psi), "stabilizer.precharge_psi": float(precharge_psi)}


def mass(load):
    return {"servo.load_mass_lbf_s2_in": float(load)}


CURVE_A = {**TWO_SLOPE, "servo.relay_piston_stroke_in": 7.5}  # its x1 goes to 6.9 in
DRAIN = {"supply.drain_pressure_psi": 3.0}
HOLD = {"load.beyond": "hold"}
# The steam valves need 8 psi less while they close.
CLOSING_CURVE = [[x, round(p - 8.0, 3)] for x, p in zip(LOAD_X3_IN, LOAD_P3_PSI)]


def scenario(name, about, x3_in, p1, *overrides, duration_s=0.6, closing_curve=None):
    merged = dict(FULL)
    for o in overrides:
        merged.update(o)
    out = {"name": name, "about": about, "start_x3_in": x3_in, "p1": p1, "duration_s": duration_s, "set": merged}
    if closing_curve:
        out["closing_curve"] = closing_curve
    return out


def sample_ticks(duration_s):
    """121 or fewer, a multiple of 5 ms apart."""
    end = round(duration_s / TICK_S)
    apart = 50 * -(-end // 6000)
    return list(range(0, end + 1, apart))


SCENARIOS = [
    # --- first ten: one of each kind -----------------------------------------------------------------
    scenario("stroke-up", "from 0.02 in into the upper stop, plunger and ports to their limits", 0.02, table((0, 45))),
    scenario("stroke-down", "from 8 in into the lower stop", 8.0, table((0, 15)), duration_s=1.2),
    scenario("trip", "P1 to 0 at 8 in: falls into the lower stop and rests", 8.0, table((0, 0)), duration_s=1.2),
    scenario("trip-r4", "the same with the recommended stabilizer: its diaphragm bottoms", 8.0, table((0, 0)),
             TABLE_VII[4], duration_s=2.0),
    scenario("both-stops", "up into one stop, down into the other, off it again", 4.0,
             table((0, 46), (0.2, 5), (1.5, 30)), duration_s=1.8),
    scenario("sag-up", "pump and accumulator: a full stroke sags the header by a third", 0.5, table((0, 46)),
             pump(200, 5000), duration_s=1.0),
    scenario("air1-up", "1 % of air, full stroke", 1.0, table((0, 42)), air(0.01)),
    scenario("cold-down", "MIL-H-5606 at -10 C", 7.0, table((0, 28)), oil("mil_h_5606", -10), duration_s=1.0),
    scenario("stribeck-steps", "breakaway 12, Coulomb 5 psi: three small steps, stuck between", 4.0,
             table((0, 30.5), (0.15, 30.2), (0.3, 30.9), (0.45, 30.4)), friction(5, 12, 0.2)),
    scenario("up2-low-r4", "load jump at 3.4 in with the recommended stabilizer", 3.2, step(2), TABLE_VII[4]),
    # --- strokes, stops, trips -------------------------------------------------------------------------
    scenario("stroke-up-two", "two-slope cam: knee on the way up", 0.1, table((0, 60)), CURVE_A),
    scenario("stroke-down-two", "two-slope cam: knee on the way down", 7.8, table((0, 16)), CURVE_A, duration_s=1.2),
    scenario("p1-300", "P1 to 300 psi and back: relay piston at its stop", 3.0, table((0, 300), (0.3, 29)), duration_s=1.2),
    scenario("trip-recover", "trip and reset half way down", 8.0, table((0, 0), (0.4, 36)), duration_s=0.9),
    scenario("trip-two", "trip, two-slope cam, from 6 in", 6.0, table((0, 0)), CURVE_A, duration_s=1.0),
    scenario("lower-stop-start", "starts at the lower stop, leaves it, returns", 0.0, table((0, 22), (0.15, 19), (0.4, 23)),
             duration_s=0.6),
    scenario("upper-stop-start", "starts at the upper stop, leaves it, returns", 8.0, table((0, 38), (0.25, 41), (0.4, 39)),
             duration_s=0.7),
    scenario("hold-stroke", "load held beyond its table, both ends", 0.5, table((0, 44), (0.3, 12)), HOLD, duration_s=1.8),
    scenario("short-stroke", "stroke 5 in, travel and ports smaller", 2.0, table((0, 50), (0.3, 0)),
             {"servo.stroke_in": 5.0, "servo.relay_plunger_travel_in": 0.06, "servo.metering_port_height_in": 0.04,
              "servo.relay_port_height_in": 0.1, "servo.relay_piston_stroke_in": 4.6}, duration_s=1.2),
    scenario("drain-trip", "3 psi in the drain", 8.0, table((0, 0), (0.9, 25)), DRAIN, duration_s=1.4),
    scenario("transition-1", "transition pressure 1 psi, trip", 5.0, table((0, 0)), {"orifice.transition_pressure_psi": 1.0},
             duration_s=0.9),
    # --- small steps along the stroke ------------------------------------------------------------------
    scenario("small-002", "0.02 in, recommended stabilizer, stiffest oil: the fastest mode of all", 0.02, step(0.27),
             TABLE_VII[4], bulk_modulus(LIQUID_PSI)),
    scenario("small-005", "0.05 in, small underlap", 0.05, step(0.4), underlap(0.001), NO_CLEARANCE, bulk_modulus(LIQUID_PSI)),
    scenario("small-2", "2 in, down", 2.0, step(-1), underlap(0.003)),
    scenario("small-6", "6 in, up through the high jump", 6.0, step(2), clearance(0.003)),
    scenario("small-8", "8 in, down a little and back into the stop", 8.0, table((0, 38.5), (0.2, 39.8)), supply(280)),
    # --- air, cavity -----------------------------------------------------------------------------------
    scenario("air05-down", "0.5 % of air, polytropic 1.2", 7.0, table((0, 22)), air(0.005, 1.2), duration_s=0.9),
    scenario("air2-small", "2 % of air dissolving at 200 psi", 4.0, step(1.0), air(0.02, 1.0, 200.0),
             duration_s=0.3),
    scenario("air5-up", "5 % of air, adiabatic, dissolving at 300 psi", 2.0, table((0, 38)), air(0.05, 1.4, 300.0)),
    scenario("air5-trip", "5 % of air, trip", 8.0, table((0, 0)), air(0.05), duration_s=1.2),
    scenario("air1-r4", "1 % of air with the recommended stabilizer", 5.0, table((0, 36), (0.3, 26)), air(0.01), TABLE_VII[4],
             duration_s=0.8),
    scenario("cavity", "a heavy load runs on when the valve shuts: the oil under the piston cavitates and is refilled",
             1.5, table((0, 45), (0.09, 0)), mass(60), {"servo.metering_port_height_in": 0.03}, duration_s=0.6),
    scenario("cavity-air", "the same with 0.5 % of air", 1.5, table((0, 45), (0.09, 0)), mass(60), air(0.005),
             {"servo.metering_port_height_in": 0.03}, duration_s=0.6),
    # --- oil -------------------------------------------------------------------------------------------
    scenario("hot-up", "MIL-H-5606 at 90 C", 3.0, table((0, 36)), oil("mil_h_5606", 90)),
    scenario("vg32-cold", "ISO VG 32 at 10 C with the recommended stabilizer", 4.0, table((0, 34), (0.3, 27)),
             oil("iso_vg_32", 10), TABLE_VII[4], duration_s=0.8),
    scenario("vg32-hot-trip", "ISO VG 32 at 70 C, trip", 6.5, table((0, 0)), oil("iso_vg_32", 70), duration_s=1.0),
    # --- friction --------------------------------------------------------------------------------------
    scenario("coulomb-strokes", "Coulomb 5 psi, into both stops", 3.0, table((0, 45), (0.25, 5)), friction(5), duration_s=1.4),
    scenario("breakaway-staircase", "breakaway 10, Coulomb 4 psi: slow staircase up, stick and slip", 4.2,
             table(*((round(0.1 * i, 4), round(30.85 + 0.05 * i, 4)) for i in range(8))), friction(4, 10, 0.1), duration_s=0.8),
    scenario("viscous-up", "viscous 0.3 psi s/in and Coulomb 3 psi", 2.0, table((0, 37)), friction(3, 0, 0.1, 0.3)),
    scenario("closing-ratio", "friction 6 psi up, 9 psi down, breakaway half more", 5.0,
             table((0, 33), (0.15, 31.5), (0.3, 33.5), (0.45, 32.5)), friction(6, 9, 0.3, 0.05, 1.5), duration_s=0.7),
    scenario("closing-curve", "8 psi less load while closing, friction 5 psi", 5.5, table((0, 31), (0.3, 34), (0.5, 30)),
             friction(5), duration_s=0.8, closing_curve=CLOSING_CURVE),
    scenario("trip-friction", "trip with breakaway 15, Coulomb 8 psi", 7.5, table((0, 0), (0.8, 28)), friction(8, 15, 0.5),
             duration_s=1.5),
    # --- stabilizer: Table VII -------------------------------------------------------------------------
    scenario("r1-up", "Table VII row 1", 4.0, table((0, 33), (0.3, 29)), TABLE_VII[1]),
    scenario("r2-down", "Table VII row 2, low jump", 4.5, table((0, 28)), TABLE_VII[2]),
    scenario("r3-up", "Table VII row 3", 4.6, step(3), TABLE_VII[3]),
    scenario("r4-stroke", "Table VII row 4, full stroke", 0.5, table((0, 43)), TABLE_VII[4]),
    scenario("r5-trip", "Table VII row 5, trip: bottoms", 7.0, table((0, 0), (0.7, 30)), TABLE_VII[5], duration_s=1.2),
    scenario("r5-precharge", "precharge 70 psi: bottoms and lifts at every load jump", 3.0, table((0, 31), (0.25, 27)),
             TABLE_VII[5], precharge(90, 70)),
    scenario("r4-friction", "recommended stabilizer, friction 5 psi", 4.2, table((0, 29), (0.3, 32)), TABLE_VII[4], friction(5),
             duration_s=0.7),
    # --- supply ----------------------------------------------------------------------------------------
    scenario("sag-small", "500 in3, 150 in3/s: a stroke empties the header", 3.6, table((0, 38)), pump(150, 500), duration_s=0.9),
    scenario("sag-cycle", "up and down on a weak supply, then it refills", 2.0, table((0, 40), (0.3, 25)), pump(250, 2000, 20.0),
             duration_s=1.2),
    scenario("sag-all", "weak supply, stabilizer, friction, air, drain pressure", 4.0, table((0, 35), (0.35, 28)),
             pump(300, 3000), TABLE_VII[4], friction(3, 5), air(0.01), DRAIN, duration_s=0.9),
]

RANDOM_SEEDS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12)


def random_scenario(seed):
    """Every parameter inside its range; three values of P1, 0.3 s each."""
    r = random.Random(seed)

    def uniform(low, high, digits=4):
        return round(r.uniform(low, high), digits)

    x3 = uniform(0.3, 7.9, 3)
    overrides = [
        underlap(uniform(0.001, 0.004)), clearance(uniform(0.0, 0.004)), bulk_modulus(uniform(80e3, 230e3, 0)),
        supply(uniform(220, 340, 1)), mass(uniform(0.5, 3.0, 3)),
        {"servo.piston_clearance_in": uniform(0.0008, 0.003, 5), "servo.capillary_diameter_in": uniform(0.17, 0.21),
         "servo.relay_volume_in3": uniform(8, 16, 2), "servo.piston_volume_at_zero_in3": uniform(20, 60, 1),
         "servo.discharge_coefficient": uniform(0.58, 0.68), "servo.metering_port_height_in": uniform(0.05, 0.25),
         "servo.relay_plunger_travel_in": uniform(0.1, 0.25), "orifice.transition_pressure_psi": uniform(0.05, 0.5),
         "oil.air_fraction": uniform(0.0, 0.05), "oil.air_polytropic_index": uniform(1.0, 1.4, 2),
         "oil.dissolution_pressure_psi": r.choice((0.0, uniform(100, 400, 1))),
         "supply.drain_pressure_psi": uniform(0, 5, 2), "load.beyond": r.choice(("hold", "extrapolate"))},
        oil(r.choice(("mil_h_5606", "iso_vg_32")), uniform(15, 80, 1)),
        r.choice(({}, CURVE_A)),
    ]
    b = uniform(1, 10, 2)
    overrides.append(r.choice(({}, friction(b, round(b * r.uniform(1, 2), 2), uniform(0.05, 0.5, 3), uniform(0, 0.2, 3),
                                            uniform(0.7, 1.5, 2)))))
    volume = uniform(20, 100, 1)
    overrides.append(r.choice(({}, {**stabilizer(uniform(0.14, 0.35, 3), uniform(7.5, 15, 2), volume),
                                    **precharge(uniform(70, 110, 1), uniform(10, 50, 1))})))
    overrides.append(r.choice(({}, pump(uniform(200, 500, 0), uniform(2000, 8000, 0), uniform(5, 20, 1)))))
    p1 = table((0, uniform(20, 48, 2)), (0.3, uniform(0, 48, 2)), (0.6, uniform(20, 40, 2)))
    return scenario(f"random-{seed}", f"random parameters, seed {seed}", x3, p1, *overrides, duration_s=0.9)


SCENARIOS += [random_scenario(seed) for seed in RANDOM_SEEDS]
assert len({s["name"] for s in SCENARIOS}) == len(SCENARIOS)
