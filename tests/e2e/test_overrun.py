"""Overruns on purpose: they are counted, classed, told on the bus, in the summary and in the statistics, and make the
run INVALID, as loop.overrun says; and simulated time never drifts.

A noisy machine adds late ticks of its own at any time: what a hold-up causes is asserted as the least there must be,
and that all accounts agree holds in any case.
"""

import json
import os
import re
import signal
import subprocess
import sys

import pytest

from control_socket import Control
from emulator import (FROZEN, IN_GUEST, NOT_VALID, OK, STOPPED, TICKS_PER_MS, let_time_pass, settings,
                      ticks_of)
from thread_pause import paused

WAKE_TICKS = 10  # loop.wake_ticks, its default
LIMIT = settings(loop__max_catch_up_ticks=300)  # 30 ms
HOLD_UP_S = 0.06
LATENESS = 0.1  # ms, resolution of the signals


def least_late_ticks(hold_up_s):
    """Of the deadlines in a hold-up each is a late wake-up, but those of the last period."""
    return (int(hold_up_s * 1000) - 1) * WAKE_TICKS


def statistics_of(file, result):
    """The JSON, which must agree with the summary."""
    stats = json.loads(file.read_text())
    late = stats["late"]
    assert stats["finished"] is True and stats["verdict"] == result.verdict and stats["state_hash"] == result.hash
    assert stats["tick"] == result.ticks and stats["timing_valid"] == (result.late_ticks == 0)
    assert late["ticks"] == result.late_ticks
    assert late["ticks"] == late["woke_late_ticks"] + late["computed_long_ticks"] + late["both_ticks"]
    told = re.search(r"late ticks \d+ \((\d+) woke late, (\d+) computed long, (\d+) both\), worst lateness ([\d.]+) ms",
                     result.text)
    assert [int(n) for n in told.groups()[:3]] == [late[f"{c}_ticks"] for c in ("woke_late", "computed_long", "both")]
    assert float(told[4]) == round(late["worst_lateness_ns"] / 1e6, 3)
    worst = stats["worst_overruns"]
    told = [(int(tick), float(ms), cause, int(behind)) for tick, ms, cause, behind in re.findall(
        r"^late +at tick (\d+) by ([\d.]+) ms, ([a-z ]+): .* (\d+) ticks behind, CPU", result.text, re.M)]
    assert told == [(w["tick"], round(w["lateness_ns"] / 1e6, 3), w["cause"], w["behind_ticks"]) for w in worst]
    assert [w["tick"] for w in worst] == sorted(w["tick"] for w in worst)
    counted = [w for w in worst if not w["in_grace"]]
    for w in worst:
        assert w["behind_ticks"] == w["lateness_ns"] // 100_000 // stats["wake_ticks"] * stats["wake_ticks"]
    # An overrun makes as many late wake-ups as it was behind, and more if catching up took long.
    assert sum(w["behind_ticks"] for w in counted) <= late["ticks"]
    assert late["worst_lateness_ns"] >= max((w["lateness_ns"] for w in counted), default=0)
    return stats


def steal(cpu):
    """Spins for 0.1 s at the highest priority on this CPU; @return how long exactly [s]"""
    spin = ("import time; begin = now = time.monotonic()\nwhile now < begin + 0.1: now = time.monotonic()\n"
            "print(now - begin)")
    done = subprocess.run(["taskset", "-c", str(cpu), "chrt", "-f", "99", sys.executable, "-c", spin],
                          capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        pytest.fail(f"SCHED_FIFO is not permitted here: run as root, or with CAP_SYS_NICE: {done.stderr}")
    return float(done.stdout)


# --- What is told ----------------------------------------------------------------------------------------------------

def test_a_hold_up_is_counted_classed_and_told(start, connect, tmp_path):
    stats = tmp_path / "stats.json"
    emulator = start("--stats", stats)
    client = connect(emulator)
    before = client.newest("SERVO_Status")
    stood_s = emulator.pause(HOLD_UP_S)
    frames = [client.newest("SERVO_Status", lambda f: f["TimingValid"] == 0), *client.for_ticks(5000)]
    statuses = [f for f in frames if f.name == "SERVO_Status"]
    assert {f["TimingValid"] for f in statuses} == {0}, "latched"
    least_ms = min(stood_s * 1000 - 1, 409.5)
    newest = statuses[-1]
    assert newest["LateTicks"] >= min(before["LateTicks"] + least_late_ticks(stood_s), 65535)
    assert newest["WorstLateness"] >= least_ms - LATENESS
    assert [f["LateTicks"] for f in statuses] == sorted(f["LateTicks"] for f in statuses)
    assert [f["WorstLateness"] for f in statuses] == sorted(f["WorstLateness"] for f in statuses)
    assert all(f["RecentLateness"] <= f["WorstLateness"] for f in statuses)
    assert min(f["RecentLateness"] for f in statuses) < newest["WorstLateness"], "is not latched"

    result = emulator.stop(may_be_late=True)
    assert result.status == NOT_VALID and result.verdict.startswith("INVALID: timing: late ticks ")
    assert result.late_ticks >= newest["LateTicks"] and "the run is INVALID" in result.log
    told = statistics_of(stats, result)
    assert told["late"]["worst_lateness_ns"] >= least_ms * 1e6
    assert any(w["behind_ticks"] >= least_late_ticks(stood_s) for w in told["worst_overruns"])


def test_recent_lateness_is_that_since_the_status_before(start, connect):
    """Statuses that were overtaken in the program take nothing of it with them: the first one after has it."""
    emulator = start(*settings(publish__status_ms=10))
    client = connect(emulator)
    client.newest("SERVO_Status")
    stood_s = emulator.pause(HOLD_UP_S)
    least_ms = min(stood_s * 1000 - 1, 102.3) - LATENESS
    frames = client.until(lambda f: f.name == "SERVO_Status" and f["WorstLateness"] >= least_ms)
    frames += client.for_ticks(2000)
    recent = [f["RecentLateness"] for f in frames if f.name == "SERVO_Status"]
    assert max(recent) >= least_ms
    emulator.stop(may_be_late=True)


def test_a_stolen_cpu_is_a_late_wake(start, connect, tmp_path):
    """A spinner of priority 99 on the loop's CPU, as a driver's thread that runs wild."""
    if IN_GUEST:
        pytest.skip("time does not pass in the guest while a process computes")
    stats = tmp_path / "stats.json"
    cpu = max(os.sched_getaffinity(0))
    emulator = start("--rt", "prefer", "--stats", stats, *settings(loop__cpu=cpu))
    client = connect(emulator)
    client.newest("SERVO_Status")
    spun_s = steal(cpu)
    client.for_ticks(3000)
    assert client.newest("SERVO_Status")["TimingValid"] == 0
    result = emulator.stop(may_be_late=True)
    told = statistics_of(stats, result)
    assert result.late_ticks >= least_late_ticks(spun_s)
    assert any(w["behind_ticks"] >= least_late_ticks(spun_s) and w["cpu"] == cpu for w in told["worst_overruns"])


def test_a_thread_held_by_a_debugger_is_late(start, connect, tmp_path):
    """One thread alone stands still: nothing is published, and then the present."""
    stats = tmp_path / "stats.json"
    emulator = start("--stats", stats)
    client = connect(emulator)
    client.newest("SERVO_Position")
    with paused(emulator.process_id, "sim"):
        let_time_pass(0.02)
        client.frames_so_far()
        let_time_pass(HOLD_UP_S)
        assert client.frames_so_far() == []
    client.for_ticks(1000)
    result = emulator.stop(may_be_late=True)
    statistics_of(stats, result)
    assert result.late_ticks >= least_late_ticks(HOLD_UP_S)


def test_work_that_takes_long_is_another_cause(start, connect, tmp_path):
    """The fault missed_ticks holds the thread in the middle of a wake-up's 1000 ticks: it woke in time, and computed
    long."""
    if IN_GUEST:
        pytest.skip("time does not pass in the guest while a process computes")
    stats = tmp_path / "stats.json"
    emulator = start("--stats", stats, "--control", tmp_path / "control",
                     *settings(loop__wake_ticks=1000, publish__position_ms=100, publish__pressures_ms=100))
    client = connect(emulator)
    client.newest("SERVO_Position")
    with Control(tmp_path / "control") as control:
        control.inject("missed_ticks", ms=250)
    client.for_ticks(3000)
    result = emulator.stop(may_be_late=True)
    late = statistics_of(stats, result)["late"]
    assert late["computed_long_ticks"] + late["both_ticks"] >= 1000
    longest = re.findall(r"^late +at tick .*computed long: longest compute before it ([\d.]+) ms", result.text, re.M)
    assert any(float(ms) >= 250 for ms in longest)


def test_time_does_not_drift(start):
    """Whatever happened: a duration is so many ticks, and the phase is that of the start."""
    emulator = start("--duration", "1.5")
    for _ in range(3):
        emulator.pause(HOLD_UP_S)
    result = emulator.wait(may_be_late=True)
    assert result.ticks == 15000 and result.late_ticks >= 3 * least_late_ticks(HOLD_UP_S)


def test_the_worst_of_many_overruns_are_kept(start, connect, tmp_path):
    """Ten of them, in the order of time."""
    stats = tmp_path / "stats.json"
    emulator = start("--stats", stats)
    client = connect(emulator)
    for hold_up_s in (0.004, 0.008, 0.012, 0.006, 0.01) * 2 + (0.05,):
        client.newest("SERVO_Position")
        emulator.pause(hold_up_s)
    client.for_ticks(1000)
    told = statistics_of(stats, emulator.stop(may_be_late=True))
    assert len(told["worst_overruns"]) == 10
    assert max(w["behind_ticks"] for w in told["worst_overruns"]) >= least_late_ticks(0.05)


# --- What is done ----------------------------------------------------------------------------------------------------

def overruns(result):
    found = re.search(r"^overrun +(\d+) times more than 300 ticks were to be caught up$", result.text, re.M)
    return int(found[1]) if found else 0


def test_catch_up_goes_on_past_the_limit_loudly(start, connect):
    emulator = start("--duration", "1.5", *LIMIT, *settings(loop__overrun="catch_up"))
    client = connect(emulator)
    client.newest("SERVO_Position")
    emulator.pause(HOLD_UP_S)
    frames = client.until_ended()
    assert {tick % (10 * TICKS_PER_MS) for tick in ticks_of(frames)} == {0}, "in phase"
    assert FROZEN not in {f["Mode"] for f in frames if f.name == "SERVO_Status"}
    result = emulator.wait(may_be_late=True)
    assert result.ticks == 15000 and result.status == NOT_VALID and overruns(result) >= 1
    assert ('overrun: more than loop.max_catch_up_ticks = 300 were to be caught up; loop.overrun = "catch_up"'
            in result.log)


def test_below_the_limit_no_policy_acts(start):
    emulator = start("--duration", "0.5", *settings(loop__overrun="stop", loop__max_catch_up_ticks=1000000))
    emulator.pause(HOLD_UP_S)
    result = emulator.wait(may_be_late=True)
    assert result.ticks == 5000 and "overrun" not in result.text + result.log


def test_freeze_stands_still_and_says_so(start, connect):
    emulator = start(*LIMIT, *settings(loop__overrun="freeze"))
    client = connect(emulator)
    client.send_p1(31.0)
    client.newest("SERVO_Position")
    emulator.pause(HOLD_UP_S)
    client.newest("SERVO_Status", lambda f: f["Mode"] == FROZEN)
    client.send_p1(60.0)  # moves nothing any more
    frames = [client.receive() for _ in range(100)]
    positions = [f for f in frames if f.name == "SERVO_Position"]
    assert len(positions) > 20 and len({(f["Tick"], f["X3"]) for f in positions}) == 1, "published, and the same"
    assert {(f["Mode"], f["TimingValid"]) for f in frames if f.name == "SERVO_Status"} == {(FROZEN, 0)}
    result = emulator.stop(may_be_late=True)
    assert result.status == NOT_VALID and result.ticks == positions[0]["Tick"] and overruns(result) >= 1
    assert 'simulated time was frozen (loop.overrun = "freeze")' in result.verdict
    assert 'loop.overrun = "freeze"' in result.log


def test_a_frozen_run_ends_with_its_duration(start):
    emulator = start("--duration", "0.6", *LIMIT, *settings(loop__overrun="freeze"))
    emulator.pause(HOLD_UP_S)
    assert emulator.wait(may_be_late=True).ticks < 6000


def test_stop_ends_the_run(start, connect):
    emulator = start(*LIMIT, *settings(loop__overrun="stop"))
    client = connect(emulator)
    client.newest("SERVO_Position")
    emulator.signal(signal.SIGSTOP)
    let_time_pass(HOLD_UP_S)
    emulator.signal(signal.SIGCONT)
    frames = client.until_ended()
    result = emulator.wait(may_be_late=True)  # by itself
    assert [f["Mode"] for f in frames if f.name == "SERVO_Status"][-1:] == [STOPPED]
    assert result.status == NOT_VALID and overruns(result) == 1
    assert 'overrun: more than loop.max_catch_up_ticks = 300 were to be caught up; loop.overrun = "stop"' in result.log


# --- Grace at the start ----------------------------------------------------------------------------------------------

def test_lateness_in_the_grace_is_told_but_does_not_count(start, connect, tmp_path):
    stats = tmp_path / "stats.json"
    emulator = start("--stats", stats, *LIMIT, *settings(loop__grace_ms=60000, loop__overrun="stop"))
    client = connect(emulator)
    client.newest("SERVO_Position")
    stood_s = emulator.pause(HOLD_UP_S)
    frames = client.for_ticks(3000)
    assert {(f["TimingValid"], f["LateTicks"]) for f in frames if f.name == "SERVO_Status"} == {(1, 0)}
    result = emulator.stop(may_be_late=False)
    assert result.status == OK and result.late_ticks == 0
    told = statistics_of(stats, result)
    assert told["late"]["in_grace_ticks"] >= least_late_ticks(stood_s)
    assert f"{told['late']['in_grace_ticks']} late ticks in the first 60000 ms do not count" in result.text
    assert told["worst_overruns"] and all(w["in_grace"] for w in told["worst_overruns"])


def test_lateness_after_the_grace_counts(start, connect):
    emulator = start(*settings(loop__grace_ms=100))
    client = connect(emulator)
    client.newest("SERVO_Position", lambda f: f["Tick"] >= 1500)
    stood_s = emulator.pause(HOLD_UP_S)
    client.for_ticks(1000)
    assert emulator.stop(may_be_late=True).late_ticks >= least_late_ticks(stood_s)
