"""`can.emulate_bitrate`: frames take their time and turn on virtual buses, so that a schedule that would fail on the
bench fails here."""

import can
import pytest

from emulator import NOT_VALID, OK, settings, ticks_of
from recordings import Recording
from scripted_governor import LOCKSTEP, TICKS, governor

BIT_RATE = settings(can__emulate_bitrate=500000)
COMMAND_US = 190  # GOV_Command: 4 bytes, 95 bits at worst-case stuffing, at 500 kbit/s


@pytest.mark.only("slcan")
def test_in_lockstep_a_command_acts_when_it_has_passed_the_bus(start, connect, tmp_path):
    """The command wins the arbitration against the answer before it and takes 190 us: two ticks of 0.1 ms have begun
    before it has passed, so each is felt from the third tick of its step on. Twice: the same run."""
    hashes = set()
    for run_ in range(2):
        emulator = start(*LOCKSTEP, *BIT_RATE, "--record", tmp_path / str(run_))
        with_answers = []
        client = connect(emulator)
        client.until = lambda wanted, *more, until=client.until: (with_answers.append(until(wanted, *more)),
                                                                  with_answers[-1])[1]
        governor(client, 20)
        result = emulator.stop()
        assert result.status == OK and result.ticks == 20 * TICKS
        recording = Recording(tmp_path / str(run_))
        first = -(-COMMAND_US // 100) + 1
        commands = [tick for tick, p1 in zip(recording.influences["tick"], recording.influences["p1_psi"]) if p1 > 0.0]
        assert commands == [step * TICKS + first for step in range(20)]
        hashes.add(result.hash)
        # The lowest identifier first: 0x200, 0x201, 0x202, 0x203, 0x204, 0x205, as real controllers would.
        names = [frame.name for answer in with_answers for frame in answer]
        assert names[:10] == ["SERVO_Position", "SERVO_Pressures", "SERVO_Relay", "SERVO_Status", "SERVO_Safety",
                              "SERVO_Bus", "SERVO_Position", "SERVO_Pressures", "SERVO_Relay", "SERVO_Status"]
    assert len(hashes) == 1


@pytest.mark.only("slcan")
def test_in_lockstep_a_schedule_that_does_not_fit_is_invalid(start, connect):
    """Five messages of 270 us each 0.5 ms: 270 % of the bus. Nothing is withheld, so that the governor goes on."""
    emulator = start(*LOCKSTEP, *BIT_RATE, *settings(lockstep__ticks=5))
    governor(connect(emulator), 100)
    result = emulator.stop()
    assert result.status == NOT_VALID and result.modelled_bus_failed
    assert "cycles missed" in result.verdict and result.ticks == 500


@pytest.mark.only("slcan")
def test_in_real_time_frames_keep_their_cycles_on_a_bus_that_carries_them(start, connect):
    emulator = start(*BIT_RATE)
    client = connect(emulator)
    frames = client.for_ticks(3000)
    client.send_p1(30.5)
    client.newest("SERVO_Pressures", lambda f: abs(f["P1_Applied"] - 30.5) < 0.005)
    ticks = ticks_of(frames)
    assert ticks == sorted(ticks) and all(tick % 100 == 0 for tick in ticks)
    result = emulator.stop()
    assert result.count["commands"] == 1
    assert "emulated " in result.text


@pytest.mark.only("slcan")
def test_in_real_time_a_bus_that_others_keep_makes_the_run_invalid(start, connect):
    """400 frames of the highest priority keep the bus for 108 ms: ten cycles of 10 ms are missed, and told."""
    emulator = start(*BIT_RATE)
    client = connect(emulator)
    client.newest("SERVO_Position")
    for _ in range(400):
        client.send(can.Message(arbitration_id=1, is_extended_id=False, data=bytes(8)))
    client.for_ticks(3000)
    result = emulator.stop()
    assert result.status == NOT_VALID and result.modelled_bus_failed, result.text
    assert result.count["of other ids"] == 400


def test_a_frame_s_bit_rate_is_checked(transport):
    from emulator import USAGE, run
    done = run("run", "--can", "slcan:pty", *settings(can__emulate_bitrate=9600), status=USAGE)
    assert "can.emulate_bitrate = 9600: must be 0 or at least 10000 bit/s" in done.stderr
    done = run("run", "--can", "slcan:pty", *settings(can__emulate_bitrate=20000), status=USAGE)
    assert "more than the bus carries" in done.stderr
