"""Independent reference solution of the servomotor over its whole envelope: `model.physics = "full"`.

Written from MODEL.md (and the thesis it cites), never from the C++ of this repository: it is the second opinion.

State      y = [x3 in, v3 in/s, q3, q4, q8, P2 psi], q = ln((P_abs - p_v) / psi) of the chambers' pressures
Units      in, lbf, s, psi gauge; mass in lbf s^2/in

The logarithm keeps its accuracy in a cavity, where P_abs - p_v is 1e-4 psi; `Settings.log_pressure = False` solves
in the pressures themselves, for comparison.

Method as in ../reference/servomotor.py: everything that makes the right-hand side or its slope jump is a discrete
mode, continued smoothly past its boundary; the boundary is located on the dense output, the next mode starts there.
"""

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "reference"))

from servomotor import LOAD_P3_PSI, LOAD_X3_IN  # noqa: E402  Appendix E's load table

P_ATM_PSI = 14.696
NUCLEI = 1e-6            # gas per liquid that is always there, MODEL.md "Oil with air"
ACCUMULATOR_INDEX = 1.4  # k of C2, MODEL.md "Supply"

PSI_PA = 6894.757293168361
RHO_KG_M3 = 4.4482216152605 / 0.0254**4  # kg/m3 in 1 lbf s^2/in^4
OILS = {  # cSt at 40 and 100 degrees C, kg/m3 at 15 degrees C; MODEL.md "Oil temperature"
    "mil_h_5606": (13.2, 4.9, 866.0),
    "iso_vg_32": (32.0, 5.4, 865.0),
}


@dataclass(frozen=True)
class Parameters:
    """What the user sets. Defaults: config/servohil.toml (Table II as corrected) and MODEL.md."""

    d1: float = 0.996       # in    relay piston rod
    d2: float = 2.494       # in    relay piston
    d3: float = 9.99        # in    main piston
    d4: float = 0.1875      # in    capillary in the relay plunger
    d6: float = 3.495       # in    relay plunger
    w1: float = 1.750       # in    relay piston orifice
    A2: float = 2.341       # in^2  above the relay plunger
    cr1: float = 0.002      # in    radial, orifice 5
    cr2: float = 0.002      # in    radial, orifices 3 and 6
    cr3: float = 0.001      # in    on diameter, main piston
    L3: float = 0.8         # in    leakage path past the main piston
    L4: float = 4.0         # in    capillary
    k1: float = 30.0        # lbf/in
    k2: float = 212.0       # lbf/in
    m3: float = 0.303       # lbf s^2/in
    me: float = 1.3656      # lbf s^2/in
    U: float = 0.002        # in    underlap
    V4: float = 11.6        # in^3  above the relay plunger
    V30: float = 30.0       # in^3  under the main piston at x3 = 0
    Kl: float = 110_000.0   # psi   modulus of the liquid
    cd: float = 0.625
    Fs: float = 13.5        # lbf   preload of spring 10
    stroke: float = 8.0     # in
    h5: float = 0.25        # in    height of orifice 5
    h36: float = 0.25       # in    height of orifices 3, 6
    x1_max: float = 8.0     # in    relay piston stroke
    travel: float = 0.25    # in    |x2 - x4| at the plunger's stops
    p_t: float = 0.1        # psi   transition pressure of every orifice
    # oil
    oil: str = "custom"
    temperature: float = 40.0  # degrees C
    mu: float = 2.2e-6      # lbf s/in^2
    rho: float = 8.0e-5     # lbf s^2/in^4
    air: float = 0.0        # gas per liquid, volumes at atmospheric pressure
    n: float = 1.0          # polytropic index of the air
    p_d: float = 0.0        # psi absolute, dissolution; 0: never
    p_v: float = 0.05       # psi absolute, vapour
    nuclei: float = NUCLEI  # (not a key; 0 in the limit of the thesis)
    # supply
    P2: float = 300.0       # psi   set point
    Q_max: float = 0.0      # in^3/s pump; 0: ideal
    p_band: float = 10.0    # psi
    V_acc: float = 500.0    # in^3
    Pe: float = 0.0         # psi   drain
    # cam
    cam: str = "single"
    alpha: float = 0.32
    x3_star: float = 2.90   # in
    lower_alpha: float = 0.90
    lower_x3_star: float = 2.10
    upper_alpha: float = 0.45
    upper_x3_star: float = 3.38
    # friction
    B: float = 0.0          # psi   Coulomb
    B_break: float = 0.0    # psi   breakaway; 0: as Coulomb
    v_s: float = 0.1        # in/s  Stribeck
    B_v: float = 0.0        # psi s/in viscous
    closing: float = 1.0    # sigma_d of downward motion
    # stabilizer
    stabilizer: bool = False
    d7: float = 0.30        # in    capillary
    L7: float = 15.0        # in
    V8: float = 100.0       # in^3  oil
    Va: float = 100.0       # in^3  gas at the charge pressure
    k: float = 1.4
    p_charge: float = 103.0  # psi
    p_pre: float = 20.0     # psi
    # load
    beyond: str = "extrapolate"  # or "hold"
    closing_curve: tuple = ()    # ((x3, psi), ...): load.closing_file


# Key of a `servohil` configuration -> field of Parameters.
CONFIGURATION_KEYS = {
    "oil.name": "oil", "oil.temperature_c": "temperature", "oil.density_lbf_s2_in4": "rho",
    "oil.viscosity_lbf_s_in2": "mu", "oil.air_fraction": "air", "oil.air_polytropic_index": "n",
    "oil.dissolution_pressure_psi": "p_d", "oil.vapour_pressure_psi": "p_v",
    "orifice.transition_pressure_psi": "p_t",
    "servo.relay_piston_rod_diameter_in": "d1", "servo.relay_piston_diameter_in": "d2",
    "servo.piston_diameter_in": "d3", "servo.capillary_diameter_in": "d4", "servo.relay_plunger_diameter_in": "d6",
    "servo.relay_port_width_in": "w1", "servo.relay_plunger_area_in2": "A2",
    "servo.relay_piston_clearance_in": "cr1", "servo.relay_plunger_clearance_in": "cr2",
    "servo.piston_clearance_in": "cr3", "servo.piston_leakage_length_in": "L3", "servo.capillary_length_in": "L4",
    "servo.pilot_spring_rate_lbf_in": "k1", "servo.main_spring_rate_lbf_in": "k2",
    "servo.main_spring_preload_lbf": "Fs", "servo.underlap_in": "U", "servo.piston_mass_lbf_s2_in": "m3",
    "servo.load_mass_lbf_s2_in": "me", "servo.relay_volume_in3": "V4", "servo.piston_volume_at_zero_in3": "V30",
    "servo.bulk_modulus_psi": "Kl", "servo.discharge_coefficient": "cd", "servo.stroke_in": "stroke",
    "servo.relay_port_height_in": "h5", "servo.metering_port_height_in": "h36",
    "servo.relay_piston_stroke_in": "x1_max", "servo.relay_plunger_travel_in": "travel",
    "supply.pressure_psi": "P2", "supply.pump_flow_in3_s": "Q_max", "supply.pump_band_psi": "p_band",
    "supply.accumulator_volume_in3": "V_acc", "supply.drain_pressure_psi": "Pe",
    "cam.shape": "cam", "cam.alpha": "alpha", "cam.x3_star_in": "x3_star", "cam.lower_alpha": "lower_alpha",
    "cam.lower_x3_star_in": "lower_x3_star", "cam.upper_alpha": "upper_alpha", "cam.upper_x3_star_in": "upper_x3_star",
    "friction.coulomb_psi": "B", "friction.breakaway_psi": "B_break", "friction.stribeck_velocity_in_s": "v_s",
    "friction.viscous_psi_s_in": "B_v", "friction.closing_ratio": "closing",
    "stabilizer.enabled": "stabilizer", "stabilizer.capillary_diameter_in": "d7",
    "stabilizer.capillary_length_in": "L7", "stabilizer.oil_volume_in3": "V8", "stabilizer.gas_volume_in3": "Va",
    "stabilizer.polytropic_index": "k", "stabilizer.charge_pressure_psi": "p_charge",
    "stabilizer.precharge_psi": "p_pre", "load.beyond": "beyond",
}


def parameters(overrides=None, closing_curve=()):
    """Parameters for a dictionary of servohil configuration keys."""
    fields = {CONFIGURATION_KEYS[k]: v for k, v in (overrides or {}).items()}
    return replace(Parameters(), closing_curve=tuple(map(tuple, closing_curve)), **fields)


def oil_properties(name, temperature_c):
    """mu [lbf s/in^2], rho [lbf s^2/in^4]: Walther (ASTM D341) through two points, linear density."""
    nu40, nu100, rho15 = OILS[name]
    w40, w100 = (math.log10(math.log10(nu + 0.7)) for nu in (nu40, nu100))
    t40, t100, t = (math.log10(c + 273.15) for c in (40.0, 100.0, temperature_c))
    B = (w40 - w100) / (t100 - t40)
    nu = 10 ** 10 ** (w40 - B * (t - t40)) - 0.7             # cSt
    rho = rho15 * (1 - 7e-4 * (temperature_c - 15))           # kg/m3
    return nu * 1e-6 * rho / PSI_PA, rho / RHO_KG_M3


@dataclass(frozen=True)
class Mode:
    """The discrete part of the state: which formula of each law holds."""

    segment: int   # of the load curves
    upper: bool    # above the cam kink
    o5: int        # orifice: 0 closed (clearance), 1 open, 2 wide open (port height)
    o3: int
    o6: int
    plunger: int   # x2 - x4 at its lower stop -1, free 0, at its upper stop +1
    seated: bool   # diaphragm of the stabilizer
    pump: int      # 1 all it can, 0 in its band, -1 off
    motion: str    # "free" (no law depends on the direction), "up", "down", "stuck", "lower", "upper" (at the stop)

    @property
    def held(self):
        return self.motion in ("stuck", "lower", "upper")


class FullServomotor:
    """The model: derived constants, laws, right-hand side, mode boundaries."""

    def __init__(self, p: Parameters, log_pressure=True):
        if p.oil != "custom":
            mu, rho = oil_properties(p.oil, p.temperature)
            p = replace(p, mu=mu, rho=rho)
        self.p = p
        self.log = log_pressure
        pi = math.pi
        self.A1 = pi * (p.d2**2 - p.d1**2) / 4                      # (2.1)
        self.A3 = pi * p.d3**2 / 4
        self.M = p.m3 + p.me
        self.k5 = p.cd * pi * p.w1 * math.sqrt(2 / p.rho)           # (2.4)
        self.k36 = p.cd * pi * p.d6 * math.sqrt(2 / p.rho)          # (2.5), (2.6)
        self.c3 = pi * p.d3 * (p.cr3 / 2)**3 / (12 * p.mu * p.L3)   # (2.8)
        self.C = p.mu * p.L3 * pi * p.d3 / (p.cr3 / 2)
        self.a4 = 128 * p.mu * p.L4 / (pi * p.d4**4)                # (2.3)
        self.b4 = 2.28 * p.rho / (16 * pi * p.mu * p.L4)
        self.a7 = 128 * p.mu * p.L7 / (pi * p.d7**4)                # (5.2) with end losses
        self.b7 = 2.28 * p.rho / (16 * pi * p.mu * p.L7)
        self.Bs = max(p.B, p.B_break)
        self.directed = self.Bs > 0 or bool(p.closing_curve)
        self.C2 = p.V_acc / (ACCUMULATOR_INDEX * (p.P2 + P_ATM_PSI))
        if p.cam == "single":
            self.lines, self.kink = ((p.alpha, p.x3_star),) * 2, None
        else:
            self.lines = ((p.lower_alpha, p.lower_x3_star), (p.upper_alpha, p.upper_x3_star))
            self.kink = (p.upper_x3_star - p.lower_x3_star) / (p.lower_alpha - p.upper_alpha)
        self._load()

    # --- load -----------------------------------------------------------------------------------
    def _load(self):
        """Segments of both curves between the knots of either: knots, [(opening line), (closing line)]."""
        opening = tuple(zip(LOAD_X3_IN, LOAD_P3_PSI))
        closing = self.p.closing_curve or opening
        self.knots = sorted({x for x, _ in opening} | {x for x, _ in closing})
        ends = [self.knots[0] - 1, *self.knots, self.knots[-1] + 1]
        middles = [(a + b) / 2 for a, b in zip(ends, ends[1:])]
        self.segments = [(self._line(opening, x), self._line(closing, x)) for x in middles]

    def _line(self, curve, x):
        """(x0, p0, slope) of the curve at x, which is between knots."""
        if self.p.beyond == "hold" and x < curve[0][0]:
            return (*curve[0], 0.0)
        if self.p.beyond == "hold" and x > curve[-1][0]:
            return (*curve[-1], 0.0)
        j = min(max(sum(x > c for c, _ in curve) - 1, 0), len(curve) - 2)
        (x0, p0), (x1, p1) = curve[j], curve[j + 1]
        return x0, p0, (p1 - p0) / (x1 - x0)

    def segment(self, x3):
        return int(np.searchsorted(self.knots, x3, side="right"))

    def load_psi(self, x3, segment, closing):
        x0, p0, slope = self.segments[segment][closing]
        return p0 + slope * (x3 - x0)

    # --- laws -----------------------------------------------------------------------------------
    def x1(self, P1):
        return min(max(self.A1 * P1 / self.p.k1, 0.0), self.p.x1_max)

    @staticmethod
    def capillary(dp, a, b):
        """Physical root of |dp| = a q (1 + b q), odd in dp."""
        return math.copysign(2 * abs(dp) / (a + math.sqrt(a * a + 4 * a * b * abs(dp))), dp)

    def root(self, dp):
        """dp / (dp^2 + p_t^2)^(1/4): sqrt|dp| sgn dp with a laminar transition."""
        s = dp * dp + self.p.p_t**2
        return dp / math.sqrt(math.sqrt(s)) if s > 0 else 0.0

    @staticmethod
    def opening(x, c, h, how):
        """sqrt(clip(x, 0, h)^2 + c^2) in its three cases; open with c = 0 continues as x."""
        if how == 0:
            return c
        if how == 2:
            return math.sqrt(h * h + c * c)
        return math.sqrt(x * x + c * c) if c > 0 else x

    def gas(self, P):
        """V_g and dV_g/dP: gas per volume of liquid."""
        p = self.p
        w = max(P + P_ATM_PSI - p.p_v, 1e-9)
        theta, slope = 1.0, 0.0
        if p.p_d > 0:
            u = P / (p.p_d - P_ATM_PSI)  # P_abs - p_atm is the gauge pressure
            if u >= 1:
                theta = 0.0
            elif u > 0:
                theta = (1 - u)**3 * (1 + 3 * u + 6 * u * u)
                slope = -30 * u * u * (1 - u)**2 / (p.p_d - P_ATM_PSI)
        g = ((P_ATM_PSI - p.p_v) / w)**(1 / p.n)
        content = p.air * theta + p.nuclei
        return content * g, p.air * slope * g - content * g / (p.n * w)

    def modulus(self, P):
        volume, slope = self.gas(P)
        return (1 + volume) / (1 / self.p.Kl - slope)

    def C8(self, P8, seated):
        p = self.p
        c = p.V8 / self.modulus(P8)
        if not seated:
            P = P8 + P_ATM_PSI
            c += p.Va * ((p.p_charge + P_ATM_PSI) / P)**(1 / p.k) / (p.k * P)
        return c

    def friction_psi(self, v, motion):
        """F / A3 of MODEL.md "Friction" in the direction of the mode."""
        p = self.p
        dry = 0.0
        if motion in ("up", "down") and self.Bs > 0:
            dry = p.B + (self.Bs - p.B) / (1 + (v / p.v_s)**2)
            if motion == "down":
                dry *= -p.closing
        return dry + p.B_v * v

    def hold_psi(self, x3, segment):
        """Lowest and highest P3 at which the piston stays at rest."""
        return (self.load_psi(x3, segment, 1) - self.p.closing * self.Bs, self.load_psi(x3, segment, 0) + self.Bs)

    def x4(self, x3, upper):
        alpha, star = self.lines[upper]
        return alpha * x3 + star

    def lift(self, P4):
        """x2 - x4 without stops."""
        return (self.p.A2 * P4 - self.p.Fs) / self.p.k2

    # --- steady state ------------------------------------------------------------------------------
    def steady(self, x3):
        """Equilibrium at x3, opening curve, no friction."""
        p = self.p
        P3 = self.load_psi(x3, self.segment(x3), 0)
        x4 = self.x4(x3, self.kink is None or x3 >= self.kink)

        def clip(x, c, h):
            return math.hypot(min(max(x, 0.0), h), c)

        def balance(P2):
            def net(d):
                return (self.k36 * clip(d + p.U, p.cr2, p.h36) * self.root(P2 - P3)
                        - self.k36 * clip(p.U - d, p.cr2, p.h36) * self.root(P3 - p.Pe) - self.c3 * (P3 - p.Pe))
            d = brentq(net, -p.travel, p.travel, xtol=1e-16, rtol=1e-15)
            P4 = (p.k2 * d + p.Fs) / p.A2
            q4 = self.capillary(P2 - P4, self.a4, self.b4)
            q3 = self.k36 * clip(d + p.U, p.cr2, p.h36) * self.root(P2 - P3)
            return d, P4, q3, q4

        P2 = p.P2
        if p.Q_max > 0:
            def supply(P2):
                _, _, q3, q4 = balance(P2)
                return P2 - p.P2 + p.p_band * (q3 + q4) / p.Q_max
            if supply(p.P2 - p.p_band) > 0:
                raise ValueError("the pump does not cover the consumption at rest")
            P2 = brentq(supply, p.P2 - p.p_band, p.P2, xtol=1e-13, rtol=1e-15)
        d, P4, q3, q4 = balance(P2)
        a = q4 / (self.k5 * self.root(P4 - p.Pe))
        if not p.cr1 <= a <= math.hypot(p.h5, p.cr1):
            raise ValueError(f"orifice 5 cannot pass Q4: {a}")
        x1 = x4 + d - math.sqrt(a * a - p.cr1**2)
        if not 0 <= x1 <= p.x1_max:
            raise ValueError(f"x1 {x1}")
        return {"x1": x1, "x2": x4 + d, "x4": x4, "P1": p.k1 * x1 / self.A1, "P2": P2, "P3": P3, "P4": P4, "Q4": q4,
                "y": self.encode(x3, 0.0, P3, P4, P3, P2)}

    # --- state --------------------------------------------------------------------------------------
    def encode(self, x3, v, P3, P4, P8, P2):
        if not self.log:
            return np.array([x3, v, P3, P4, P8, P2])
        off = P_ATM_PSI - self.p.p_v
        return np.array([x3, v, math.log(P3 + off), math.log(P4 + off), math.log(P8 + off), P2])

    def decode(self, y):
        """x3, v3, P3, P4, P8, P2 as floats."""
        x3, v, q3, q4, q8, P2 = y.tolist()
        if not self.log:
            return x3, v, q3, q4, q8, P2
        off = self.p.p_v - P_ATM_PSI
        return x3, v, math.exp(q3) + off, math.exp(q4) + off, math.exp(q8) + off, P2

    # --- modes ------------------------------------------------------------------------------------
    @staticmethod
    def _how(x, h):
        return 0 if x <= 0 else 1 if x < h else 2

    def mode(self, y, x1, motion):
        p = self.p
        x3, _, _, P4, P8, P2 = self.decode(y)
        upper = self.kink is None or x3 >= self.kink
        e = self.lift(P4)
        plunger = 1 if e > p.travel else -1 if e < -p.travel else 0
        d = min(max(e, -p.travel), p.travel)
        gap = self.x4(x3, upper) + d - x1
        pump = 1 if P2 <= p.P2 - p.p_band else -1 if P2 > p.P2 else 0
        return Mode(self.segment(x3), bool(upper), self._how(gap, p.h5), self._how(d + p.U, p.h36),
                    self._how(p.U - d, p.h36), plunger, P8 < p.p_pre, pump, motion)

    def start_motion(self, x3):
        if x3 <= 0:
            return "lower"
        if x3 >= self.p.stroke:
            return "upper"
        return "stuck" if self.directed else "free"

    def moving(self, direction):
        return direction if self.directed else "free"

    def flows(self, y, m: Mode, x1):
        p = self.p
        x3, v, P3, P4, P8, P2 = y
        d = self.lift(P4) if m.plunger == 0 else m.plunger * p.travel
        x4 = self.x4(x3, m.upper)
        q3 = self.k36 * self.opening(d + p.U, p.cr2, p.h36, m.o3) * self.root(P2 - P3)
        q4 = self.capillary(P2 - P4, self.a4, self.b4)
        q5 = self.k5 * self.opening(x4 + d - x1, p.cr1, p.h5, m.o5) * self.root(P4 - p.Pe)
        q6 = self.k36 * self.opening(p.U - d, p.cr2, p.h36, m.o6) * self.root(P3 - p.Pe)
        q8 = self.capillary(P3 - P8, self.a7, self.b7) if p.stabilizer else 0.0
        return q3, q4, q5, q6, q8

    def rhs(self, m: Mode, x1):
        """dy/dt in mode m at relay piston position x1."""
        p = self.p
        alpha = self.lines[m.upper][0]
        relay = p.A2**2 / p.k2 if m.plunger == 0 else 0.0
        off = P_ATM_PSI - p.p_v
        closing = int(m.motion == "down")

        def f(_t, y):
            state = x3, v, P3, P4, P8, P2 = self.decode(y)
            q3, q4, q5, q6, q8 = self.flows(state, m, x1)
            if m.held:
                v = dv = 0.0
            else:
                dv = (self.A3 * (P3 - self.load_psi(x3, m.segment, closing) - self.friction_psi(v, m.motion))
                      - self.C * v) / self.M
            dP3 = (q3 - q6 - q8 - self.A3 * v - self.c3 * (P3 - p.Pe)) * self.modulus(P3) / (p.V30 + self.A3 * x3)
            dP4 = (q4 - q5 - p.A2 * alpha * v) / (p.V4 / self.modulus(P4) + relay)
            dP8 = q8 / self.C8(P8, m.seated) if p.stabilizer else 0.0
            dP2 = 0.0
            if p.Q_max > 0:
                share = (0.0, (p.P2 - P2) / p.p_band, 1.0)[m.pump + 1]
                dP2 = (p.Q_max * share - q3 - q4) / self.C2
            if self.log:
                return [v, dv, dP3 / (P3 + off), dP4 / (P4 + off), dP8 / (P8 + off), dP2]
            return [v, dv, dP3, dP4, dP8, dP2]

        return f

    def margins(self, m: Mode, x1):
        """[(name, hysteresis)], g: y -> values that are >= 0 in mode m."""
        p = self.p
        names, parts = [], []

        def add(name, g, eps=1e-13):
            names.append((name, eps))
            parts.append(g)  # g(x3, v, P3, P4, P8, P2, e, d, gap)

        def port(name, how, h, x):
            if how == 0:
                add((name, 1), lambda *s: -x(*s))
            elif how == 1:
                add((name, 0), lambda *s: x(*s))
                add((name, 2), lambda *s: h - x(*s))
            else:
                add((name, 1), lambda *s: x(*s) - h)

        port("o5", m.o5, p.h5, lambda x3, v, P3, P4, P8, P2, e, d, gap: gap)
        if m.plunger == 0:
            port("o3", m.o3, p.h36, lambda x3, v, P3, P4, P8, P2, e, d, gap: d + p.U)
            port("o6", m.o6, p.h36, lambda x3, v, P3, P4, P8, P2, e, d, gap: p.U - d)
            add(("plunger", 1), lambda x3, v, P3, P4, P8, P2, e, d, gap: p.travel - e)
            add(("plunger", -1), lambda x3, v, P3, P4, P8, P2, e, d, gap: e + p.travel)
        else:
            add(("plunger", 0), lambda x3, v, P3, P4, P8, P2, e, d, gap: m.plunger * e - p.travel)
        if p.stabilizer:
            lifted = -1 if m.seated else 1
            add(("seated", not m.seated), lambda x3, v, P3, P4, P8, P2, e, d, gap: lifted * (P8 - p.p_pre), 1e-11)
        if p.Q_max > 0:
            if m.pump == 1:
                add(("pump", 0), lambda x3, v, P3, P4, P8, P2, e, d, gap: p.P2 - p.p_band - P2, 1e-11)
            elif m.pump == -1:
                add(("pump", 0), lambda x3, v, P3, P4, P8, P2, e, d, gap: P2 - p.P2, 1e-11)
            else:
                add(("pump", 1), lambda x3, v, P3, P4, P8, P2, e, d, gap: P2 - p.P2 + p.p_band, 1e-11)
                add(("pump", -1), lambda x3, v, P3, P4, P8, P2, e, d, gap: p.P2 - P2, 1e-11)
        if m.held:
            if m.motion != "lower":
                add(("motion", "down"), lambda x3, v, P3, P4, P8, P2, e, d, gap:
                    P3 - self.hold_psi(x3, m.segment)[0], 1e-11)
            if m.motion != "upper":
                add(("motion", "up"), lambda x3, v, P3, P4, P8, P2, e, d, gap:
                    self.hold_psi(x3, m.segment)[1] - P3, 1e-11)
        else:
            if m.segment > 0:
                low = self.knots[m.segment - 1]
                add(("segment", m.segment - 1), lambda x3, *s: x3 - low)
            if m.segment < len(self.knots):
                high = self.knots[m.segment]
                add(("segment", m.segment + 1), lambda x3, *s: high - x3)
            if self.kink is not None:
                above = 1 if m.upper else -1
                add(("upper", not m.upper), lambda x3, *s: above * (x3 - self.kink))
            add(("stop", "lower"), lambda x3, *s: x3)
            add(("stop", "upper"), lambda x3, *s: p.stroke - x3)
            if m.motion == "up":
                add(("rest", 0), lambda x3, v, *s: v, 1e-12)
            if m.motion == "down":
                add(("rest", 0), lambda x3, v, *s: -v, 1e-12)

        def g(y):
            x3, v, P3, P4, P8, P2 = self.decode(y)
            e = self.lift(P4)
            d = e if m.plunger == 0 else m.plunger * p.travel
            s = (x3, v, P3, P4, P8, P2, e, d, self.x4(x3, m.upper) + d - x1)
            return [part(*s) for part in parts]

        return names, g

    def after(self, event, m: Mode, y):
        """Mode and state after the boundary `event` of mode m was crossed at y."""
        kind, to = event
        if kind == "motion":
            return replace(m, motion=self.moving(to)), y
        if kind not in ("stop", "rest"):
            return replace(m, **{kind: to}), y
        y = y.copy()
        y[1] = 0.0
        if kind == "stop":
            y[0] = 0.0 if to == "lower" else self.p.stroke
        x3, _, P3, _, _, _ = self.decode(y)
        low, high = self.hold_psi(x3, m.segment)
        if P3 < low and to != "lower":
            return replace(m, motion=self.moving("down")), y
        if P3 > high and to != "upper":
            return replace(m, motion=self.moving("up")), y
        return replace(m, motion=to if kind == "stop" else "stuck"), y
