#!/usr/bin/python3
"""Runs a scripted governor in lockstep with `servohil run` many times, over one bus: all state hashes must be one.

  tests/e2e/lockstep_soak.py                                           1,000 runs over slcan:pty
  tests/e2e/lockstep_soak.py --disturb                                 SIGSTOP and SIGCONT of either side at random
  tests/e2e/lockstep_soak.py --programs build/release build/asan       builds by turns, compared
  tools/vcan-guest -- tests/e2e/lockstep_soak.py --can socketcan:vcan0 in virtual time, over a real SocketCAN stack

Exit status: 0 one hash; 1 more than one, a run failed, or the hash is blind to a parameter; 2 usage.
"""
import argparse
import collections
import multiprocessing
import os
import random
import signal
import sys
import time
from pathlib import Path

from emulator import IN_GUEST, OK, PROGRAM, Client, Emulator, settings
from scripted_governor import LOCKSTEP, TICKS, governor

MODEL = {"friction__coulomb_psi": 3}
OTHER_MODEL = {**MODEL, "oil__air_fraction": 0.001}  # the hash must tell it from the other
STOPPED_S = (0.0, 0.02)  # how long a side stands still
GOVERNOR_MOVES_S = (0.0, 0.5)  # and how long the governor then moves


def hash_of_a_run(arguments, program, chance=None, model=MODEL):
    """State hash after `arguments.commands` commands; with a random generator the emulator is stopped now and then."""
    with Emulator([arguments.can], *LOCKSTEP, "--control", "none", *settings(**model), program=program) as emulator:
        def disturb(step):
            if chance and chance.random() < 0.1:
                emulator.signal(signal.SIGSTOP)
                emulator.continue_after(chance.uniform(*STOPPED_S))

        with Client(emulator.urls[0]) as client:
            governor(client, arguments.commands, disturb)
        result = emulator.stop()
    assert result.status == OK and result.ticks == arguments.commands * TICKS, result.text
    return result.hash


def soak(arguments):
    """All runs; ends the process."""
    chance = random.Random(arguments.seed) if arguments.disturb else None
    hashes = {program: collections.Counter() for program in arguments.programs}
    begin_s = time.monotonic()
    for done in range(1, arguments.runs + 1):
        program = arguments.programs[done % len(arguments.programs)]
        try:
            hashes[program][hash_of_a_run(arguments, program, chance)] += 1
        except (AssertionError, OSError) as error:
            sys.exit(f"lockstep_soak: run {done}, {program}: {error}")
        if done % max(1, arguments.runs // 10) == 0:
            print(f"{done} runs, {time.monotonic() - begin_s:.0f} s", flush=True)
    sys.exit(report(arguments, hashes, time.monotonic() - begin_s))


def report(arguments, hashes, took_s):
    for program, counts in hashes.items():
        print(f"{program}: " + ", ".join(f"{number} x {name}" for name, number in counts.most_common()))
    unit = "s of virtual time" if IN_GUEST else "s"
    print(f"{arguments.runs} runs of {arguments.commands} commands over {arguments.can}, {took_s:.1f} {unit}, "
          f"{arguments.runs / took_s:.1f} runs/s")
    every = {name for counts in hashes.values() for name in counts}
    if hash_of_a_run(arguments, arguments.programs[0], model=OTHER_MODEL) in every:
        print("NOT SHOWN: another air fraction has the same hash")
        return 1
    print("one hash" if len(every) == 1 else f"DIFFERENT: {len(every)} hashes")
    return 0 if len(every) == 1 else 1


def stop_now_and_then(process, chance):
    """SIGSTOP and SIGCONT until it ends."""
    while process.exitcode is None:
        process.join(chance.uniform(*GOVERNOR_MOVES_S))
        if process.exitcode is None:  # not reaped, so that its number is still its own
            os.kill(process.pid, signal.SIGSTOP)
            time.sleep(chance.uniform(*STOPPED_S))
            os.kill(process.pid, signal.SIGCONT)


def soak_disturbed(arguments):
    """The governor in a process of its own, which this one stops."""
    process = multiprocessing.get_context("fork").Process(target=soak, args=[arguments])
    process.start()
    try:
        stop_now_and_then(process, random.Random(arguments.seed + 1))
    finally:
        if process.exitcode is None:
            process.terminate()
            os.kill(process.pid, signal.SIGCONT)
        process.join()
    return process.exitcode


def program_of(text):
    """A program, or a build folder that has it."""
    path = Path(text).resolve()
    path = path / "bin" / "servohil" if path.is_dir() else path
    if not os.access(path, os.X_OK):
        raise argparse.ArgumentTypeError(f"{path} is no program; cmake --build --preset release --target servohil")
    return path


def natural(text):
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1")
    return int(text)


def arguments_of_the_user():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=natural, default=1000, help="default 1000")
    parser.add_argument("--commands", type=natural, default=30, help="of a run, 100 ticks each; default 30")
    parser.add_argument("--can", metavar="URL", default="slcan:pty", help="default slcan:pty")
    parser.add_argument("--disturb", action="store_true", help="stop and continue emulator and governor at random")
    parser.add_argument("--seed", type=int, default=4, help="of --disturb; default 4")
    parser.add_argument("--programs", nargs="+", metavar="FILE|BUILD", help="programs, or build folders; default: "
                        "build/release, or SERVOHIL_BUILD")
    arguments = parser.parse_args()
    try:
        arguments.programs = list(map(program_of, arguments.programs or [PROGRAM]))
    except argparse.ArgumentTypeError as error:
        parser.error(str(error))
    return arguments


def main():
    arguments = arguments_of_the_user()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # so that the emulator is ended, too
    if arguments.disturb:
        sys.exit(soak_disturbed(arguments))
    soak(arguments)


if __name__ == "__main__":
    main()
