"""`servohil run --clock lockstep`: simulated time passes only when the governor's frames say so, so that every run of
the same governor is the same run, whatever the machine does meanwhile."""

import random
import signal
import subprocess
from pathlib import Path

import pytest
from emulator import OK, PROGRAM, RUNNING, Emulator, run, settings
from scripted_governor import LOCKSTEP, REST_P1_PSI, TICKS, governor

SOAK = Path(__file__).resolve().with_name("lockstep_soak.py")


def test_each_command_is_answered_with_every_message_at_its_tick(start, connect):
    emulator = start(*LOCKSTEP)
    client = connect(emulator)
    for step in range(1, 6):
        client.send_p1(REST_P1_PSI)
        answer = client.until(lambda f: f.name == "SERVO_Status")
        assert [f.name for f in answer] == ["SERVO_Position", "SERVO_Pressures", "SERVO_Relay", "SERVO_Bus",
                                            "SERVO_Safety", "SERVO_Status"]
        assert answer[0]["Tick"] == step * TICKS
        assert answer[-1]["Mode"] == RUNNING and answer[-1]["TimingValid"] == 1
    result = emulator.stop()
    assert result.ticks == 5 * TICKS and not result.real_time and result.status == OK


def test_time_stands_still_without_commands(start, connect):
    """However long the governor takes: between two commands pass the same ticks."""
    emulator = start(*LOCKSTEP)
    client = connect(emulator)
    client.send_p1(REST_P1_PSI)
    client.newest("SERVO_Status")
    with Emulator(["slcan:pty"], "--rt", "off", "--duration", "0.3") as clock:
        clock.wait(may_be_late=True)
    assert client.frames_so_far() == []
    client.send_p1(REST_P1_PSI)
    assert client.newest("SERVO_Position")["Tick"] == 2 * TICKS
    emulator.stop()


def test_the_sync_frame_lets_time_pass_if_configured(start, connect):
    import can
    emulator = start(*LOCKSTEP, *settings(lockstep__sync_id=0x80, lockstep__ticks=25))
    client = connect(emulator)
    sync = can.Message(arbitration_id=0x80, is_extended_id=False, data=b"")
    client.send_p1(REST_P1_PSI + 1.0)  # no time passes
    client.send(sync)
    position = client.newest("SERVO_Position")
    assert position["Tick"] == 25
    client.newest("SERVO_Status", lambda f: f["Mode"] == RUNNING)
    for step in range(2, 5):  # the command holds
        client.send(sync)
        answer = client.until(lambda f: f.name == "SERVO_Status")
        assert answer[0]["Tick"] == 25 * step
        assert answer[1]["P1_Applied"] == pytest.approx(REST_P1_PSI + 1.0, abs=0.005)
    assert emulator.stop().ticks == 100


def hash_of_a_run(start, connect, steps=60, before_each=lambda emulator: lambda step: None, **more):
    emulator = start(*LOCKSTEP, *settings(friction__coulomb_psi=3, **more))
    client = connect(emulator)
    governor(client, steps, before_each(emulator))
    client.close()
    result = emulator.stop()
    assert result.ticks == steps * TICKS and result.status == OK
    return result.hash


def test_every_run_of_a_scripted_governor_is_the_same(start, connect):
    assert len({hash_of_a_run(start, connect) for _ in range(5)}) == 1
    assert hash_of_a_run(start, connect) != hash_of_a_run(start, connect, oil__air_fraction=0.001), "else no hash"


def test_stopping_either_side_changes_nothing(start, connect):
    """SIGSTOP and SIGCONT at random, of the emulator while the governor sends, and the governor (this process) waits."""
    undisturbed = hash_of_a_run(start, connect)
    chance = random.Random(4)

    def disturb(emulator):
        def before_each(step):
            if chance.random() < 0.3:
                emulator.signal(signal.SIGSTOP)
                emulator.continue_after(chance.uniform(0.0, 0.02))
        return before_each

    for _ in range(3):
        assert hash_of_a_run(start, connect, before_each=disturb) == undisturbed


def test_the_duration_ends_it_at_its_tick(start, connect):
    emulator = start(*LOCKSTEP, "--duration", "0.025")
    client = connect(emulator)
    for _ in range(3):
        client.send_p1(REST_P1_PSI)
        client.newest("SERVO_Status")
    assert emulator.wait().ticks == 250


def test_fast_and_lockstep_are_one_code_path(start, connect, tmp_path):
    """The same commands as a script: the same hash."""
    commands = [REST_P1_PSI + 0.001 * round(1000 * (0.3 * ((7 * k) % 5) - 0.6)) for k in range(40)]
    emulator = start(*LOCKSTEP)
    client = connect(emulator)
    for p1 in commands:
        client.send_p1(p1)
        client.newest("SERVO_Status")
    result = emulator.stop()
    script = tmp_path / "script.csv"
    # What the frame carries: P1_Demand in steps of 0.001 psi.
    script.write_text("t_s,p1_psi\n" + "".join(f"{k * TICKS * 1e-4:.4f},{round(p1 / 0.001) * 0.001!r}\n"
                                               for k, p1 in enumerate(commands)))
    fast = run("run", "--clock", "fast", "--script", script, "--duration", len(commands) * TICKS * 1e-4).stdout
    assert f"hash     {result.hash}" in fast


@pytest.mark.only("slcan")
def test_the_soak_knows_a_program_that_differs(url, tmp_path):
    other = tmp_path / "other"
    other.write_text(f'#!/bin/sh\nexec {PROGRAM} "$@" --set servo.bulk_modulus_psi=90000\n')
    other.chmod(0o755)

    def soak(*programs):
        return subprocess.run([SOAK, "--runs", "4", "--disturb", "--can", url, "--programs", *programs],
                              capture_output=True, text=True, timeout=100)

    one = soak(PROGRAM, PROGRAM)
    assert one.returncode == 0 and one.stdout.endswith("\none hash\n"), one
    two = soak(PROGRAM, other)
    assert two.returncode == 1 and two.stdout.endswith("\nDIFFERENT: 2 hashes\n"), two
