"""tools/plot.py draws recordings: when faults acted, and what the frames said beside what was true."""

import subprocess
import sys

import pytest
from emulator import REPOSITORY, run
from recordings import Recording as Read
from scripted_governor import REST_P1_PSI

sys.path.insert(0, str(REPOSITORY / "tools"))
from plot_recording import Recording  # noqa: E402

PLOT = REPOSITORY / "tools" / "plot.py"
SCENARIO = """
duration_s = 0.5
[[fault]]
name = "sensor_offset"
signal = "x3"
by = 0.1
at_s = 0.2
for_s = 0.1
[[fault]]
name = "load_step"
at_s = 0.3
[[expect]]
never = "MODEL_FAULT"
"""


@pytest.fixture
def recording(start, connect, tmp_path):
    """Of a run in lockstep, whose frames are a tenth of an inch off for a while."""
    (tmp_path / "offset.toml").write_text(SCENARIO)
    emulator = start("--clock", "lockstep", "--scenario", tmp_path / "offset.toml", "--record", tmp_path / "rec",
                     "--control", "none")
    client = connect(emulator)
    for _ in range(50):
        client.send_p1(REST_P1_PSI)
        client.newest("SERVO_Status")
    client.until_ended()
    emulator.end()
    return tmp_path / "rec"


def test_faults_are_bands_from_their_start_to_their_end(recording):
    bands = Recording(recording).bands()
    assert [name for name, *_ in bands] == ["sensor_offset", "load_step"]
    assert bands[0][1:] == pytest.approx((0.2001, 0.3001))
    assert bands[1][1:] == pytest.approx((0.3001, 0.5)), "to the end: it was never cleared"


def test_the_frames_are_decoded_with_the_recorded_dbc(recording):
    """As the program's own account of them has it, and off the truth by the offset, while that acts."""
    times, values = Recording(recording).published({"X3"})["X3"]
    read = Read(recording)
    assert values == pytest.approx(list(read.published["SERVO_Position"]["X3"]))
    truth = dict(zip(read.ticks, read.samples["x3_in"]))
    for t_s, value in zip(times, values):
        off = 0.1 if 0.2 < t_s <= 0.3 else 0.0
        assert value - truth[round(t_s / 1e-4)] == pytest.approx(off, abs=0.0002)


def test_a_picture_is_drawn(recording, tmp_path):
    picture = tmp_path / "picture.png"
    subprocess.run([PLOT, recording, "-o", picture, "--window", "0.1", "0.4"], check=True, timeout=120)
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000


def test_what_is_no_recording_is_told_in_one_line(tmp_path):
    done = subprocess.run([PLOT, tmp_path, "-o", tmp_path / "x.png"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"plot.py: {tmp_path}: not a recording that can be read")


def test_a_run_without_frames_has_none(tmp_path):
    run("simulate", "--duration", "0.01", "--record", tmp_path / "rec")
    assert Recording(tmp_path / "rec").published({"X3"}) == {}
