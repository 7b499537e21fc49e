#!/usr/bin/python3
"""How long a request to inject or clear a fault takes over the control socket, of a run in real time. Prints the share
that took more than 10 ms, and p50, p99 and the longest:

    tests/e2e/acknowledge_latency.py [REQUESTS]
"""

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from control_socket import Control  # noqa: E402
from emulator import Emulator  # noqa: E402

GOAL_MS = 10.0


def main(requests):
    took_ms = []
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory, "control.sock")
        with Emulator(["slcan:pty"], "--control", path) as emulator, Control(path) as control:
            for number in range(requests):
                begin = time.monotonic_ns()
                if number % 2 == 0:
                    control.inject("load_step", psi=1 + number % 50, for_s=1)
                else:
                    control.clear()
                took_ms.append((time.monotonic_ns() - begin) / 1e6)
            emulator.stop(may_be_late=True)
    took_ms.sort()
    at = lambda share: took_ms[min(len(took_ms) - 1, int(share * len(took_ms)))]  # noqa: E731
    late = sum(t > GOAL_MS for t in took_ms)
    print(f"{requests} requests: p50 {at(0.5):.2f} ms, p99 {at(0.99):.2f} ms, longest {took_ms[-1]:.2f} ms; "
          f"{late} took more than {GOAL_MS:g} ms")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
