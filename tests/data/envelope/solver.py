"""Solves a FullServomotor in time: one integrator run per mode, boundaries located on the dense output."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import BDF, LSODA, Radau
from scipy.optimize import brentq

from full_servomotor import FullServomotor

METHODS = {"Radau": Radau, "BDF": BDF, "LSODA": LSODA}


@dataclass
class Settings:
    method: str = "Radau"
    rtol: float = 1e-9
    atol: tuple = (1e-11, 1e-8, 1e-10, 1e-10, 1e-10, 1e-8)
    max_step: float = 5e-4
    probes: int = 3            # points per step at which the mode margins are examined
    log_pressure: bool = True


def jacobian(f):
    """Forward differences: a Newton iteration needs no more, and states that do not act cannot upset it."""
    def j(t, y):
        base = np.array(f(t, y))
        columns = []
        for i in range(len(y)):
            h = 1e-7 * max(abs(y[i]), 1e-2)
            moved = y.copy()
            moved[i] += h
            columns.append((np.array(f(t, moved)) - base) / h)
        return np.array(columns).T

    return j


class Result:
    def __init__(self):
        self.samples = []  # (x3, v3, P3, P4, P8, P2)
        self.stuck = []
        self.events = []   # (t, event, v3 before)
        self.rest = []     # [t_from, t_to, "stuck" | "lower" | "upper", depth psi]: piston at rest
        self.low, self.high = np.full(6, math.inf), np.full(6, -math.inf)
        self.steps = 0


def simulate(servo: FullServomotor, y0, p1_schedule, times, settings=None):
    """Solution at `times` (ascending), P1 piecewise constant: [(t_from, p1), ...] from 0 on."""
    s = settings or Settings()
    result = Result()
    y, end = np.array(y0, dtype=float), times[-1]
    stops = sorted({t for t, _ in p1_schedule if t < end} | {0.0, end})
    schedule = dict(p1_schedule)
    motion = servo.start_motion(y[0])
    rest = [0.0, None, motion, 0.0] if motion != "free" else None
    i, mode, x1, step, chatter = 0, None, None, None, 0

    def sample(state, stuck):
        result.samples.append(servo.decode(state))
        result.stuck.append(int(stuck))

    sample(y, motion != "free")
    i = 1
    t = 0.0
    for begin, stop in zip(stops, stops[1:]):
        if begin in schedule:
            x1 = servo.x1(schedule[begin])
        mode = servo.mode(y, x1, mode.motion if mode else motion) if mode is None else replace(
            servo.mode(y, x1, mode.motion), segment=mode.segment, upper=mode.upper)
        step = None
        while t < stop:
            f = servo.rhs(mode, x1)
            solver = METHODS[s.method](f, t, y, stop, rtol=s.rtol, atol=np.array(s.atol),
                                       max_step=s.max_step, jac=jacobian(f), first_step=step and min(step, stop - t))
            names, g = servo.margins(mode, x1)
            crossed = None
            while solver.status == "running" and crossed is None:
                message = solver.step()
                if solver.status == "failed":
                    raise RuntimeError(f"{s.method} at t = {solver.t}: {message}, {mode}")
                result.steps += 1
                dense = solver.dense_output()
                crossed = first_crossing(names, g, dense, solver.t_old, solver.t, solver.y, s.probes)
                until = crossed[0] if crossed else solver.t
                while i < len(times) and times[i] <= until:
                    sample(dense(times[i]) if times[i] < solver.t else solver.y, mode.held)
                    i += 1
                state = np.array(servo.decode(dense(until) if crossed else solver.y))
                result.low = np.minimum(result.low, state)
                result.high = np.maximum(result.high, state)
                if rest:
                    low, high = servo.hold_psi(y[0], mode.segment)
                    gap = {"lower": high - state[2], "upper": state[2] - low}.get(
                        mode.motion, min(high - state[2], state[2] - low))
                    rest[3] = max(rest[3], gap)
            if crossed is None:
                t, y = solver.t, solver.y.copy()
                continue
            when, event = crossed
            chatter = chatter + 1 if when - t < 1e-12 else 0
            if chatter > 20:
                raise RuntimeError(f"modes do not settle at t = {when}: {event}, {mode}")
            y = dense(when)
            result.events.append((when, event, float(y[1])))
            was, (mode, y) = mode, servo.after(event, mode, y)
            if mode.held and not was.held:
                rest = [when, None, mode.motion, 0.0]
            elif was.held and not mode.held:
                rest[1] = when
                result.rest.append(rest)
                rest = None
            t = when
            step = 1e-7
    if rest:
        rest[1] = t
        result.rest.append(rest)
    while i < len(times):
        sample(y, mode.held)
        i += 1
    result.samples = np.array(result.samples)
    return result


def first_crossing(names, g, dense, t0, t1, y1, probes):
    """First (time, event) in (t0, t1] at which a margin falls below minus its hysteresis."""
    last = t0
    for i in range(1, probes + 1):
        t = t0 + (t1 - t0) * i / probes if i < probes else t1
        values = g(y1 if i == probes else dense(t))
        best = None
        for j, (name, eps) in enumerate(names):
            if values[j] < -eps:
                def h(when, j=j, eps=eps):
                    return g(dense(when))[j] + eps
                if h(last) < 0:
                    when = last
                elif h(t) >= 0:
                    when = t  # dense output and end point differ by rounding
                else:
                    when = brentq(h, last, t, xtol=1e-16, rtol=8.9e-16)
                if best is None or when < best[0]:
                    best = (when, name)
        if best:
            return best
        last = t
    return None
