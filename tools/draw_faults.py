#!/usr/bin/python3
"""Draws the small pictures of FAULTS.md: each fault of the catalogue in a run of its own, the same commands in all.

    tools/draw_faults.py                       # all, into .github/pictures/faults
    tools/draw_faults.py supply_sag -o /tmp    # some

Faults of the servomotor and its sensors in lockstep, those of bus and emulator in real time. Needs h5py, matplotlib,
python-can and canmatrix (tools/deps.sh test)."""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from plot_recording import Recording, draw  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[1]
PICTURES = REPOSITORY / ".github" / "pictures" / "faults"
REST_PSI, UP_PSI = 30.263, 31.5
STEPS_S = ((0.0, REST_PSI), (0.3, UP_PSI), (0.6, REST_PSI), (1.3, UP_PSI), (1.6, REST_PSI))
MOST_LATE_NS = 10_000_000
FAULT_S, FOR_S, DURATION_S, CYCLE_S = 0.9, 1.0, 2.4, 0.01
AIRY = ("servo.bulk_modulus_psi = 230000", "oil.air_fraction = 0.02", "stabilizer.enabled = true")
STABILIZED = ("stabilizer.enabled = true",)
# What the defaults would not show: (parameters, settings).
SPECIAL = {
    "air_entrainment": ({}, ("servo.bulk_modulus_psi = 230000",)),
    "bulk_modulus": ({"psi": 20000}, ()),
    "cold_oil": ({"temperature_c": -20}, ()),
    "hot_oil": ({"temperature_c": 120}, ()),
    "main_spring_weak": ({"rate_lost": 0.8}, ()),
    "piston_leak": ({"clearance_in": 0.02}, ()),
    "capillary_plugged": ({"area_lost": 0.8}, ()),
    "relay_port_silted": ({"width_lost": 0.8}, ()),
    "plunger_worn": ({"underlap_in": 0.02, "clearance_in": 0.01}, ()),
    "plunger_overlapped": ({"overlap_in": 0.01}, ()),
    "coulomb_friction": ({"psi": 40}, ()),
    "stiction": ({"psi": 60}, ()),
    "stabilizer_isolated": ({}, AIRY),
    "stabilizer_capillary_plugged": ({"area_lost": 0.95}, AIRY),
    "gas_charge_lost": ({"volume_lost": 0.99}, AIRY),
    "diaphragm_ruptured": ({}, AIRY),
    "stem_stuck": ({"from_in": 3.8, "over_in": 1}, ()),
    "tx_lost": ({"probability": 0.5}, ()),
    "rx_delayed": ({"delay_s": 0.2}, ()),
    "sensor_noise": ({"sigma": 0.02}, ()),
    "sensor_drift": ({"per_s": 0.3}, ()),
    "sensor_delayed": ({"delay_s": 0.1}, ()),
}


class Mistake(Exception):
    """One line for the user."""


def catalogue(program):
    """{fault: part} and {fault: its own parameters}, of those that have a picture"""
    text = subprocess.run([program, "fault", "list", "--markdown"], capture_output=True, text=True, check=True).stdout
    parts, own, part, pictured = {}, {}, "", set()
    for line in text.splitlines():
        if match := re.match(r"## On the (.*)", line):
            part = match[1]
        elif match := re.match(r"### (\w+)", line):
            name = match[1]
            parts[name], own[name] = part, set()
        elif match := re.match(r"!\[(\w+)\]", line):
            pictured.add(match[1])
        elif match := re.match(r"\| `(\w+)`", line):
            if parts:
                own[name].add(match[1])
    return {fault: part for fault, part in parts.items() if fault in pictured}, own


def scenario(name, part, own):
    """The scenario file of one fault."""
    parameters, settings = SPECIAL.get(name, ({}, STABILIZED if part == "stabilizer" else ()))
    lines = [f"duration_s = {DURATION_S}", "[configuration]", *settings, 'fault.armed = "yes"', "[[fault]]",
             f'name = "{name}"', f"at_s = {FAULT_S}", f"for_s = {FOR_S}"]
    lines += [f"{key} = {value}" for key, value in parameters.items() if key in own]
    if part == "sensors":
        lines.append('signal = "x3"')
    return "\n".join([*lines, "[[expect]]", 'never = "MODEL_FAULT"', ""])


def command(p1_psi):
    import can
    raw = round(p1_psi / 0.001) << 12  # GOV_Command of config/servohil.dbc
    return can.Message(arbitration_id=0x100, is_extended_id=False, data=raw.to_bytes(4, "little"))


def demand(t_s):
    return [p1 for at_s, p1 in STEPS_S if at_s <= t_s + 1e-9][-1]


def govern(port, lockstep):
    """Commands P1 until the emulator is gone; in lockstep each command is answered before the next."""
    import can
    with can.Bus(interface="slcan", channel=port, bitrate=500000, sleep_after_open=0.0) as bus:
        begin = time.monotonic()
        for n in range(round(DURATION_S / CYCLE_S) + 100):
            bus.send(command(demand(n * CYCLE_S)))
            if lockstep:
                while (frame := bus.recv(5.0)) is not None and frame.arbitration_id != 0x203:
                    pass
            else:
                time.sleep(max(0.0, begin + (n + 1) * CYCLE_S - time.monotonic()))
                while bus.recv(0.0) is not None:
                    pass


def record(program, name, part, own, folder):
    """Runs it. @return the recording's directory"""
    lockstep = part not in ("bus", "emulator")
    file = folder / f"{name}.toml"
    file.write_text(scenario(name, part, own))
    process = subprocess.Popen(
        [program, "run", "--can", "slcan:pty", "--scenario", file, "--record", folder / name, "--control", "none",
         "--rt", "off", *(["--clock", "lockstep"] if lockstep else [])],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=REPOSITORY)
    try:
        ready = process.stdout.readline()
        if not ready.startswith("ready: slcan:"):
            raise Mistake(f"{name}: {process.stderr.read().strip() or ready}")
        try:
            govern(ready.split(";")[0].removeprefix("ready: slcan:"), lockstep)
        except (OSError, Exception) as error:  # the emulator has come to its end, and its terminal with it
            if process.wait(10) not in (0, 1, 4):
                raise Mistake(f"{name}: {error}") from None
    finally:
        process.kill()
        process.communicate()
    return folder / name


def recorded(program, name, part, own, folder):
    """In real time until the machine was not late: that would be another fault's picture."""
    for attempt in range(10):
        (folder / str(attempt)).mkdir()
        recording = Recording(record(program, name, part, own, folder / str(attempt)))
        late_ns = recording.samples["worst_lateness_ns"][-1] if len(recording.t_s) else 0
        if recording.attributes["clock"] == "lockstep" or part == "emulator" or late_ns < MOST_LATE_NS:
            return recording
    raise Mistake(f"{name}: this machine is too busy for a run in real time")


def picture(program, name, part, own, output):
    with tempfile.TemporaryDirectory() as folder:
        recording = recorded(program, name, part, own, Path(folder))
        recording.begin_with_the_first_command()
        of_frames = part in ("sensors", "bus", "emulator")
        draw(recording, output / f"{name}.png", panels=("p1_psi", "x3_in") if of_frames else ("x3_in", "p3_psi"),
             size=(5.2, 2.7), dots=of_frames, window=(0.2, DURATION_S),
             as_on_the_bus=part in ("bus", "emulator"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faults", nargs="*", metavar="FAULT", help="default: all of the catalogue")
    parser.add_argument("-o", "--output", type=Path, default=PICTURES, metavar="DIR")
    parser.add_argument("--program", type=Path, default=Path(os.environ.get("SERVOHIL_BUILD", REPOSITORY / "build/release"))
                        / "bin/servohil")
    args = parser.parse_args()
    parts, own = catalogue(args.program)
    for name in args.faults or parts:
        if name not in parts:
            raise Mistake(f"there is no fault {name}")
        picture(args.program, name, parts[name], own[name], args.output)
        print(f"{args.output / name}.png", flush=True)


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"draw_faults.py: {mistake}", file=sys.stderr)
        sys.exit(1)
