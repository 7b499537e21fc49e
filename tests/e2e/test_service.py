"""The units of systemd/: hardened as wanted, and at work under a real systemd, in a container of the CAN guest."""

import os
import re
import subprocess

import pytest
from emulator import BUILD, REPOSITORY

SERVICE = REPOSITORY / "tests" / "e2e" / "service"


@pytest.mark.parametrize("unit", ["servohil@.service", "servohil-vcan@.service"])
def test_the_exposure_is_at_most_2(unit):
    done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", REPOSITORY / "systemd" / unit],
                          capture_output=True, text=True, timeout=60)
    score = re.search(r"Overall exposure level for .*: ([\d.]+) ", done.stdout)
    assert score, done.stdout + done.stderr
    print(score[0])
    assert float(score[1]) <= 2.0


def test_the_units_at_work(tmp_path):
    if os.environ.get("SERVOHIL_GUEST"):
        pytest.fail("it starts a guest of its own: run it outside of one")
    subprocess.run(["cmake", "--install", BUILD, "--prefix", "/usr/local"], check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, DESTDIR=str(tmp_path)), timeout=60)
    done = subprocess.run(
        [REPOSITORY / "tools" / "vcan-guest", "--timeout", "300", "--memory", "1G", "--", SERVICE / "container.sh", tmp_path,
         "/usr/bin/python3", "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rA", "--color=no", SERVICE / "check_service.py"],
        capture_output=True, text=True, timeout=400)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
