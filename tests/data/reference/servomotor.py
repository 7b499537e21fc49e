"""Independent reference solution of the nonlinear hydraulic servomotor.

Written from the equations of the source (thesis chapters II, IV, V and appendices A, E, H, as
corrected by its errata), never from the C++ of this repository: it is the second opinion.

State      y = [x3 in, v3 in/s, P3 psi, P4 psi, P8 psi]
Units      in, lbf, s, psi gauge; mass in lbf s^2/in

Every place where the right-hand side, or its slope, jumps (orifice cases, load-table knots, cam
kink, stick and slip) is a *mode*. Within a mode the right-hand side is smooth and is continued
smoothly across the mode's boundary, so that the integrator never steps over a kink; the boundary
is then located on the dense output and the integration restarts there in the next mode.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau
from scipy.optimize import brentq

HERE = Path(__file__).resolve().parent
METHODS = {"DOP853": DOP853, "LSODA": LSODA, "Radau": Radau}

# Appendix E's load table (errata 9, 10): x3 [in], P3 [psi] that balances the load at rest.
LOAD_X3_IN = (1.00, 1.25, 1.50, 1.75, 2.00, 2.25, 2.50, 2.75, 3.00, 3.25, 3.35,
              3.40, 3.50, 3.75, 4.00, 4.25, 4.50, 4.75, 5.00, 5.25, 5.50, 5.75, 6.00, 6.25,
              6.30, 6.50, 6.75, 7.00, 7.25, 7.50, 7.75, 8.00)
LOAD_P3_PSI = (67.5, 63.5, 60.5, 56.5, 53.5, 51.0, 49.0, 47.5, 46.5, 45.5, 45.0,
               131.0, 127.0, 115.0, 103.0, 91.0, 80.5, 74.5, 71.0, 69.0, 67.0, 67.0, 67.0, 67.0,
               150.0, 135.5, 124.0, 116.5, 111.0, 107.0, 105.0, 103.0)


@dataclass(frozen=True)
class Parameters:
    """What the user sets. Defaults: Table II as corrected (errata 1, 2, 5, 6)."""

    d1: float = 0.996       # in    relay piston rod
    d2: float = 2.494       # in    relay piston
    d3: float = 9.99        # in    main piston
    d4: float = 3.0 / 16.0  # in    capillary in the relay plunger
    d6: float = 3.495       # in    relay plunger
    w1: float = 1.750       # in    relay piston orifice
    A2: float = 2.341       # in^2  above the relay plunger (errata 1)
    cr1: float = 0.002      # in    radial, orifice 5
    cr2: float = 0.002      # in    radial, orifices 3 and 6
    cr3: float = 0.001      # in    on diameter, main piston (errata 2)
    L3: float = 0.8         # in    leakage path past the main piston
    L4: float = 4.0         # in    capillary
    k1: float = 30.0        # lbf/in
    k2: float = 212.0       # lbf/in
    m3: float = 0.303       # lbf s^2/in
    me: float = 1.3656      # lbf s^2/in
    U: float = 0.002        # in    underlap
    V4: float = 11.6        # in^3  above the relay plunger
    V30: float = 30.0       # in^3  under the main piston at x3 = 0 (errata 5)
    mu: float = 2.2e-6      # lbf s/in^2
    rho: float = 8.0e-5     # lbf s^2/in^4
    beta: float = 110_000.0  # psi
    cd: float = 0.625
    Fs: float = 13.5        # lbf   preload of spring 10
    P2: float = 300.0       # psi   supply
    cam: str = "single"     # or "two_slope": Curve A (errata 8)
    alpha: float = 0.32     # single-slope cam, (2.15)
    x3_star: float = 2.90   # in
    B: float = 0.0          # psi   Coulomb friction, (4.4)
    stabilizer: bool = False
    d7: float = 0.30        # in    stabilizer capillary
    L7: float = 15.0        # in
    V8: float = 100.0       # in^3  oil
    Va: float = 100.0       # in^3  gas, constant in the thesis' form (errata 18)
    k: float = 1.4          # adiabatic exponent


# Key of a `servohil` configuration -> field of Parameters.
CONFIGURATION_KEYS = {
    "servo.underlap_in": "U",
    "servo.relay_piston_clearance_in": "cr1",
    "servo.relay_plunger_clearance_in": "cr2",
    "servo.bulk_modulus_psi": "beta",
    "supply.pressure_psi": "P2",
    "cam.shape": "cam",
    "cam.alpha": "alpha",
    "cam.x3_star_in": "x3_star",
    "friction.coulomb_psi": "B",
    "stabilizer.enabled": "stabilizer",
    "stabilizer.capillary_diameter_in": "d7",
    "stabilizer.capillary_length_in": "L7",
    "stabilizer.oil_volume_in3": "V8",
    "stabilizer.gas_volume_in3": "Va",
}


def parameters(overrides=None):
    """Parameters for a dictionary of servohil configuration keys."""
    return replace(Parameters(), **{CONFIGURATION_KEYS[k]: v for k, v in (overrides or {}).items()})


@dataclass
class Mode:
    """The discrete part of the state: which formula of each law holds."""

    segment: int    # load-table segment 0 .. 30
    upper: bool     # above the cam kink
    open5: bool     # x2 - x1 > 0
    open3: bool     # x2 - x4 + U > 0
    open6: bool     # x4 - x2 + U > 0
    slide: int      # sign of v3 while sliding; 0: at rest, held by friction, or no friction at all


class Servomotor:
    """The model: derived constants, laws, right-hand side, mode boundaries."""

    def __init__(self, p: Parameters):
        self.p = p
        pi = math.pi                                      # errata 7
        self.A1 = pi * (p.d2**2 - p.d1**2) / 4            # (2.1)
        self.A3 = pi * p.d3**2 / 4
        self.M = p.m3 + p.me                              # (2.12), (2.13)
        self.k5 = p.cd * pi * p.w1 * math.sqrt(2 / p.rho)  # (2.4)
        self.k36 = p.cd * pi * p.d6 * math.sqrt(2 / p.rho)  # (2.5), (2.6)
        self.c3 = pi * p.d3 * (p.cr3 / 2)**3 / (12 * p.mu * p.L3)  # (2.8), errata 3
        self.C = p.mu * p.L3 * pi * p.d3 / (p.cr3 / 2)    # Appendix E, errata 4
        self.cap_a = 128 * p.mu * p.L4 / (pi * p.d4**4)   # (2.3), errata 11
        self.cap_b = 2.28 * p.rho / (16 * pi * p.mu * p.L4)
        self.D4 = p.V4 / p.beta + p.A2**2 / p.k2          # from (2.11) with (2.2)
        self.G7 = pi * p.d7**4 / (128 * p.mu * p.L7) if p.stabilizer else 0.0  # (5.2)
        if p.cam == "single":
            self.lines = ((p.alpha, p.x3_star), (p.alpha, p.x3_star))
            self.kink = None
        elif p.cam == "two_slope":                        # errata 8
            self.lines = ((0.90, 2.10), (0.45, 3.38))
            self.kink = (3.38 - 2.10) / (0.90 - 0.45)     # 2.8444 in
        else:
            raise ValueError(p.cam)

    # --- laws -----------------------------------------------------------------------------------
    def load_psi(self, x3, segment=None):
        """P_load(x3) = F_ext/A3, linear interpolation, end segments extrapolated (errata 10)."""
        j = self.segment(x3) if segment is None else segment
        x0, x1, f0, f1 = LOAD_X3_IN[j], LOAD_X3_IN[j + 1], LOAD_P3_PSI[j], LOAD_P3_PSI[j + 1]
        return f0 + (x3 - x0) * (f1 - f0) / (x1 - x0)

    @staticmethod
    def segment(x3):
        j = int(np.searchsorted(LOAD_X3_IN, x3, side="right")) - 1
        return min(max(j, 0), len(LOAD_X3_IN) - 2)

    def x4(self, x3, upper):
        alpha, star = self.lines[upper]
        return alpha * x3 + star                          # (2.15) with the sign of (A.11)

    def x2(self, x4, P4):
        return (self.p.A2 * P4 - self.p.Fs) / self.p.k2 + x4  # (2.2)

    def x1(self, P1):
        return self.A1 * P1 / self.p.k1                   # (2.1)

    def q4(self, dp):
        """Capillary (2.3), physical root, odd in dp (errata 11)."""
        q = (-1 + math.sqrt(1 + 4 * self.cap_b * abs(dp) / self.cap_a)) / (2 * self.cap_b)
        return math.copysign(q, dp)

    @staticmethod
    def _opening(x, c, is_open):
        """sqrt(x^2 + c^2) when open, c when closed; for c = 0 the smooth continuation is x."""
        if not is_open:
            return c
        return math.sqrt(x * x + c * c) if c > 0 else x

    def flows(self, x1, x2, x4, P3, P4, open3, open5, open6):
        """Q3, Q4, Q5, Q6: (2.5), (2.3), (2.4), (2.6)."""
        p = self.p
        dp = p.P2 - P3
        q3 = math.copysign(math.sqrt(abs(dp)), dp) * self.k36 * self._opening(x2 - x4 + p.U, p.cr2, open3)
        q5 = math.copysign(math.sqrt(abs(P4)), P4) * self.k5 * self._opening(x2 - x1, p.cr1, open5)
        q6 = math.copysign(math.sqrt(abs(P3)), P3) * self.k36 * self._opening(x4 - x2 + p.U, p.cr2, open6)
        return q3, self.q4(p.P2 - P4), q5, q6

    # --- steady state: (A.1) to (A.11), with the leakage of (2.8) ---------------------------------
    def steady(self, x3, friction=0.0):
        """Equilibrium at x3. `friction` [psi] in -B .. +B: part of the load carried by friction,
        positive when it opposes upward motion."""
        p = self.p
        P3 = self.load_psi(x3) + friction
        x4 = self.x4(x3, self.kink is None or x3 >= self.kink)

        def net(d):  # Q3 - Q6 - c3 P3 as a function of d = x2 - x4; increasing
            q3, _, _, q6 = self.flows(0, x4 + d, x4, P3, 1, d + p.U > 0, True, -d + p.U > 0)
            return q3 - q6 - self.c3 * P3

        d = brentq(net, -0.05, 0.05, xtol=1e-16, rtol=1e-15)
        x2 = x4 + d
        P4 = (p.k2 * d + p.Fs) / p.A2
        q4 = self.q4(p.P2 - P4)
        x1 = x2 - math.sqrt((q4 / (self.k5 * math.sqrt(P4)))**2 - p.cr1**2)
        return {"x1": x1, "x2": x2, "x4": x4, "P1": p.k1 * x1 / self.A1, "P3": P3, "P4": P4, "Q4": q4,
                "y": np.array([x3, 0.0, P3, P4, P3])}

    # --- modes ------------------------------------------------------------------------------------
    def mode(self, y, x1, slide):
        x3, _, _, P4, _ = y
        upper = self.kink is None or x3 >= self.kink
        x4 = self.x4(x3, upper)
        x2 = self.x2(x4, P4)
        return Mode(self.segment(x3), bool(upper), x2 - x1 > 0, x2 - x4 + self.p.U > 0,
                    x4 - x2 + self.p.U > 0, slide)

    def rhs(self, m: Mode, x1):
        """dy/dt in mode m at relay piston position x1."""
        p = self.p
        stuck = p.B > 0 and m.slide == 0
        alpha = self.lines[m.upper][0]

        def f(_t, y):
            x3, v, P3, P4, P8 = (float(c) for c in y)
            x4 = self.x4(x3, m.upper)
            x2 = self.x2(x4, P4)
            q3, q4, q5, q6 = self.flows(x1, x2, x4, P3, P4, m.open3, m.open5, m.open6)
            q8 = self.G7 * (P3 - P8)                                        # (5.2)
            if stuck:
                v = dv = 0.0
            else:                                                           # (2.12), (2.13), (4.4)
                dv = (self.A3 * (P3 - self.load_psi(x3, m.segment) - p.B * m.slide) - self.C * v) / self.M
            dP3 = (q3 - q6 - q8 - self.A3 * v - self.c3 * P3) * p.beta / (p.V30 + self.A3 * x3)  # (5.12)
            dP4 = (q4 - q5 - p.A2 * alpha * v) / self.D4                    # (2.9), (2.11), (2.2)
            dP8 = q8 / (p.V8 / p.beta + p.Va / (p.k * P8)) if p.stabilizer else 0.0  # (5.13)
            return [v, dv, dP3, dP4, dP8]

        return f

    def margins(self, m: Mode, x1):
        """Functions g(y) >= 0 that hold in mode m: [(name, g, hysteresis)]."""
        p = self.p
        out = []

        def opening(y):  # x2 - x4
            return (p.A2 * y[3] - p.Fs) / p.k2

        def sign(flag):
            return 1.0 if flag else -1.0

        s5, s3, s6 = sign(m.open5), sign(m.open3), sign(m.open6)
        out.append(("open5", lambda y: s5 * (opening(y) + self.x4(y[0], m.upper) - x1), 1e-13))
        out.append(("open3", lambda y: s3 * (opening(y) + p.U), 1e-13))
        out.append(("open6", lambda y: s6 * (p.U - opening(y)), 1e-13))
        stuck = p.B > 0 and m.slide == 0
        if stuck:
            held = p.B
            out.append(("breakaway+", lambda y: held - (y[2] - self.load_psi(y[0], m.segment)), 1e-11))
            out.append(("breakaway-", lambda y: held + (y[2] - self.load_psi(y[0], m.segment)), 1e-11))
        else:
            if m.segment > 0:
                lower = LOAD_X3_IN[m.segment]
                out.append(("segment-", lambda y: y[0] - lower, 1e-13))
            if m.segment < len(LOAD_X3_IN) - 2:
                higher = LOAD_X3_IN[m.segment + 1]
                out.append(("segment+", lambda y: higher - y[0], 1e-13))
            if self.kink is not None:
                s = sign(m.upper)
                out.append(("cam", lambda y: s * (y[0] - self.kink), 1e-13))
            if p.B > 0:
                out.append(("stop", lambda y: m.slide * y[1], 1e-12))
        return out

    def after(self, name, m: Mode, y):
        """Mode (and state) after the boundary `name` of mode m was crossed at y."""
        if name in ("open5", "open3", "open6"):
            return replace(m, **{name: not getattr(m, name)}), y
        if name == "segment-":
            return replace(m, segment=m.segment - 1), y
        if name == "segment+":
            return replace(m, segment=m.segment + 1), y
        if name == "cam":
            return replace(m, upper=not m.upper), y
        if name in ("breakaway+", "breakaway-"):
            return replace(m, slide=1 if name[-1] == "+" else -1), y
        if name == "stop":  # comes to rest; stays if friction can hold it, else slides back
            y = y.copy()
            y[1] = 0.0
            drive = y[2] - self.load_psi(y[0], m.segment)
            if abs(drive) <= self.p.B:
                return replace(m, slide=0), y
            return replace(m, slide=1 if drive > 0 else -1), y
        raise AssertionError(name)


@dataclass
class Settings:
    method: str = "DOP853"
    rtol: float = 1e-11
    atol: tuple = (1e-13, 1e-10, 1e-10, 1e-11, 1e-10)
    max_step: float = 1e-4  # s; also the scale on which double crossings are looked for
    probes: int = 4         # points per step at which the mode margins are examined


class Result:
    def __init__(self):
        self.samples = []     # (x3, v3, P3, P4, P8)
        self.stuck = []       # 0/1 per sample
        self.events = []      # (t, name)
        self.rest = []        # [t_from, t_to, depth psi] of every stick phase; depth: largest B - |drive|
        self.low = np.full(5, math.inf)
        self.high = np.full(5, -math.inf)


def simulate(servo: Servomotor, y0, p1_schedule, times, settings=None):
    """Solution at `times` (ascending), P1 piecewise constant: [(t_from, p1), ...], t_from ascending.

    The piston starts at rest: with Coulomb friction it is held until the drive exceeds it.
    """
    s = settings or Settings()
    method = METHODS[s.method]
    result = Result()
    y = np.array(y0, dtype=float)
    friction = servo.p.B > 0
    stops = sorted(set(times) | {t for t, _ in p1_schedule})
    stops = [t for t in stops if t <= times[-1]]
    wanted, schedule = set(times), dict(p1_schedule)
    t = stops[0]
    slide, rest_since, step, mode, x1 = 0, (t if friction else None), None, None, None
    depth = 0.0
    chatter = 0
    for i, stop in enumerate(stops):
        while t < stop:  # one integrator run per mode
            solver = method(servo.rhs(mode, x1), t, y, stop, rtol=s.rtol, atol=np.array(s.atol),
                            max_step=s.max_step, first_step=None if step is None else min(step, stop - t))
            margins = servo.margins(mode, x1)
            crossed = None
            while solver.status == "running" and crossed is None:
                message = solver.step()
                if solver.status == "failed":
                    raise RuntimeError(f"{s.method} at t = {solver.t}: {message}")
                step = solver.step_size if solver.status == "running" else step
                dense = solver.dense_output()
                crossed = first_crossing(margins, dense, solver.t_old, solver.t, solver.y, s.probes)
                result.low = np.minimum(result.low, solver.y)
                result.high = np.maximum(result.high, solver.y)
                if friction and slide == 0:
                    depth = max(depth, servo.p.B - abs(solver.y[2] - servo.load_psi(y[0])))
            if crossed is None:
                t, y = solver.t, solver.y.copy()
                continue
            when, name = crossed
            chatter = chatter + 1 if when - t < 1e-12 else 0
            if chatter > 20:
                raise RuntimeError(f"modes do not settle at t = {when}: {name}, {mode}")
            y = dense(when)
            mode, y = servo.after(name, mode, y)
            t, step = when, None
            result.events.append((when, name))
            if friction and slide != 0 and mode.slide == 0:
                rest_since, depth = when, 0.0
            elif friction and slide == 0 and mode.slide != 0:
                result.rest.append([rest_since, when, depth])
                rest_since = None
            slide = mode.slide
        if stop in wanted:
            result.samples.append(y.copy())
            result.stuck.append(int(friction and slide == 0))
        if stop in schedule:
            x1 = servo.x1(schedule[stop])
            mode = servo.mode(y, x1, slide)
    if rest_since is not None:
        result.rest.append([rest_since, t, depth])
    result.samples = np.array(result.samples)
    return result


def first_crossing(margins, dense, t0, t1, y1, probes):
    """First (time, name) in (t0, t1] at which a margin falls below minus its hysteresis."""
    best = None
    ts = [t0 + (t1 - t0) * i / probes for i in range(probes + 1)]
    ys = [dense(t) for t in ts[:-1]] + [y1]
    for name, g, eps in margins:
        for i in range(1, probes + 1):
            if g(ys[i]) < -eps:
                lo, hi = ts[i - 1], ts[i]
                if g(ys[i - 1]) < -eps:  # already outside at the start of the interval
                    when = lo
                elif g(dense(hi)) >= -eps:
                    when = hi            # dense output and end point differ by rounding
                else:
                    when = brentq(lambda t: g(dense(t)) + eps, lo, hi, xtol=1e-18, rtol=8.9e-16)
                if best is None or when < best[0]:
                    best = (when, name)
                break
    return best


def eigenvalues(servo: Servomotor, y, P1):
    """Eigenvalues of the right-hand side at y by central differences, friction ignored."""
    free = Servomotor(replace(servo.p, B=0.0))
    x1 = free.x1(P1)
    n = 5 if servo.p.stabilizer else 4
    scale = np.array([1e-6, 1e-4, 1e-3, 1e-5, 1e-3])
    jac = np.zeros((n, n))
    mode = free.mode(y, x1, 0)
    f = free.rhs(mode, x1)
    for j in range(n):
        d = np.zeros(5)
        d[j] = scale[j]
        jac[:, j] = (np.array(f(0, y + d)) - np.array(f(0, y - d)))[:n] / (2 * scale[j])
    return np.linalg.eigvals(jac)
