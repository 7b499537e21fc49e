"""The governor against the servomotor. In lockstep (the default) a run is the same on every machine and every time."""

import os
import signal
import time

import pytest
from governor import Governor

REST_PSI = 30.263  # `servohil steady --x3 4`: where the emulator starts


@pytest.fixture
def governor():
    return Governor(REST_PSI)


def drive(servohil, governor, set_point_in, duration_s):
    """The states of every cycle while the governor holds this set point."""
    states = [servohil.cycle(governor.p1_psi)]
    for _ in range(round(duration_s / Governor.CYCLE_S)):
        states.append(servohil.cycle(governor.cycle(set_point_in, states[-1].x3_in)))
    return states


def test_reaches_its_set_point(servohil, governor):
    states = drive(servohil, governor, 4.5, duration_s=1.5)
    assert states[-1].x3_in == pytest.approx(4.5, abs=0.005)
    assert max(state.x3_in for state in states) < 4.55, "overshoot"


@pytest.mark.servohil(settings={"friction.coulomb_psi": 5.0})
def test_friction_leaves_no_offset(servohil, governor):
    """A servomotor that sticks: 5 psi is what an old one has in the field."""
    states = drive(servohil, governor, 4.5, duration_s=3.0)
    assert states[-1].x3_in == pytest.approx(4.5, abs=0.02)


def test_air_in_the_oil_does_not_upset_it(servohil, governor):
    """Air enters while the governor holds its position."""
    if not servohil.can_inject:
        pytest.skip("this version of servohil injects no faults")
    drive(servohil, governor, 4.5, duration_s=1.5)
    servohil.inject("air_entrainment", fraction=0.02, ramp_s=0.5)
    states = drive(servohil, governor, 4.5, duration_s=3.0)
    assert states[-1].active_faults == 1
    assert all(4.4 < state.x3_in < 4.6 for state in states)


@pytest.mark.servohil(clock="real", settings={"loop.wake_ticks": 100})
def test_reaches_its_set_point_in_real_time(servohil, governor):
    """On the wall clock a busy machine may be late: the test is then INVALID, whatever it asserts, is run once more,
    and never passes by luck. A wake-up every 10 ms (100 ticks) makes that rare on a shared runner. To see it:
    SHOW_INVALID=1 pytest -k real_time"""
    if os.environ.get("SHOW_INVALID"):
        os.kill(servohil.process.pid, signal.SIGSTOP)
        time.sleep(0.05)
        os.kill(servohil.process.pid, signal.SIGCONT)
    states = drive(servohil, governor, 4.5, duration_s=1.5)
    assert states[-1].x3_in == pytest.approx(4.5, abs=0.005)
