"""The command line: what it says, and what it answers to every mistake: exit status 2 (usage, configuration) or 3 (the
machine), and one line that names where, what, and what would be right."""

import csv
import io
import json
import re
import shutil
import subprocess
import tomllib

import pytest

from emulator import CONFIGURATION, DBC, ENVIRONMENT, OK, PROGRAM, REPOSITORY, USAGE, run, settings

HEADER = ("t_s,p1_psi,x3_in,v3_in_s,p3_psi,p4_psi,p8_psi,x1_in,x2_in,x4_in,q3_in3_s,q4_in3_s,q5_in3_s,q6_in3_s,"
          "friction_psi,stuck")
STEADY = ("steady", "--x3", "4")            # the shortest run that reads the configuration
RUN = ("run", "--can", "slcan:pty", "--rt", "off", "--duration", "0.01")  # ... and the DBC file


def mistake(*arguments, status=USAGE):
    """The line that the program says about it: the first, where one change makes several mistakes."""
    done = run(*arguments, status=status)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("servohil: info: ")]
    assert (len(lines) == 1 or "unknown key" in lines[0]) and done.stdout == "", done
    assert lines[0].startswith("servohil: ")
    return lines[0]


def says(line, *parts):
    for part in parts:
        assert part in line, f"{part!r} is not in: {line}"


@pytest.fixture
def configuration(tmp_path):
    """A copy of the configuration, to change: configuration(old, new) → its path and the changed line's number."""
    shutil.copytree(CONFIGURATION.parent, tmp_path, dirs_exist_ok=True)

    def change(old, new, name=CONFIGURATION.name):
        file = tmp_path / name
        text = file.read_text()
        assert text.count(old) >= 1, old
        line = text[:text.index(old)].count("\n") + 1
        file.write_text(text.replace(old, new, 1))
        return file, line

    return change


# --- Help ------------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("command, units", [
    ((), ["in, lbf, s, psi gauge", "0.1 ms"]),
    (("run",), ["[s]", "socketcan:IFACE", "slcan:pty"]),
    (("simulate",), ["[in]", "[s]", "[psi]", "tick of 0.1 ms", "t_s,p1_psi"]),
    (("steady",), ["[in]", "[psi gauge]"]),
], ids=lambda value: " ".join(value) if isinstance(value, tuple) else "")
def test_help(command, units):
    text = run(*command, "--help").stdout
    says(text, *units)
    assert not run(*command, "--help").stderr


def test_help_tells_the_exit_statuses():
    says(re.sub(r"\s+", " ", run("--help").stdout), "0 ok", "1 the run was not valid", "2 usage or configuration", "3 the machine")


def test_version():
    version = re.search(r"project\(servohil VERSION ([\d.]+)", (REPOSITORY / "CMakeLists.txt").read_text())[1]
    assert run("--version").stdout == f"servohil {version}\n"


def flat(table, prefix=""):
    for key, value in table.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def test_every_key_is_in_the_file_and_in_the_help_with_its_default():
    in_file = dict(flat(tomllib.loads(CONFIGURATION.read_text())))
    text = run("run", "--help-keys").stdout
    in_help = {m[1]: m[2] for m in re.finditer(r"^  ([a-z_0-9]+(?:\.[a-z_0-9]+)+) = (.*)$", text, re.M)}
    assert in_help.keys() == in_file.keys()
    for key, value in in_file.items():
        shown = in_help[key]
        if isinstance(value, (str, list, bool)):
            assert shown.startswith(json.dumps(value)), key
        else:
            assert float(shown.split()[0]) == value, key
        unit = next((u for suffix, u in (("_in", "in"), ("_psi", "psi"), ("_ms", "ms"), ("_in3", "in³"), ("_in2", "in²"))
                     if key.endswith(suffix)), "")
        says(shown, unit)


# --- Usage -----------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("arguments, parts", [
    ((), ["subcommand is required"]),
    (("walk",), ["walk"]),
    (("run", "--cann", "slcan:pty"), ["--cann"]),
    (("run", "--rt", "maybe"), ["--rt", "maybe", "require", "prefer", "off"]),
    (("run", "--duration", "0"), ["--duration", "0"]),
    (("run", "--duration", "soon"), ["--duration", "soon"]),
    (("run", "--can", "vcan"), ["unknown bus 'vcan'", "socketcan:IFACE"]),
    (("run", "--can", "pty"), ["did you mean slcan:pty?"]),
    (("run", "--can", "/dev/ttyACM0"), ["did you mean slcan:/dev/ttyACM0?"]),
    (("simulate",), ["--duration"]),
    (("simulate", "--duration", "1", "--every", "0"), ["--every", "0"]),
    (("simulate", "--duration", "1", "--p1-step", "1", "--p1-file", "x.csv"), ["--p1-file", "--p1-step"]),
    (("simulate", "--duration", "1", "--x3", "9"), ["x3", "9"]),
    (("steady",), ["--x3 IN or --p1 PSI"]),
    (("steady", "--x3", "4", "--p1", "30"), ["--x3", "--p1"]),
    (("steady", "--p1", "5"), ["P1 = 5 psi", "from x3 = 0 to 8 in", "psi"]),
    (("steady", "--p1", "90"), ["P1 = 90 psi", "from x3 = 0 to 8 in", "psi"]),
    (("steady", "--x3", "4", "--set", "supply.pressure_psi=100"), ["103 psi", "100 psi"]),
], ids=lambda value: " ".join(value) if isinstance(value, tuple) else "")
def test_usage_mistakes(arguments, parts):
    says(mistake(*arguments), *parts)


# --- Configuration ---------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("old, new, parts", [
    ("underlap_in = 0.002 ", "underlab_in = 0.002 ", ["servo.underlab_in", "did you mean servo.underlap_in?"]),
    ("[friction]", "[frction]", ["unknown key", "frction.coulomb_psi", "friction.coulomb_psi"]),
    ("underlap_in = 0.002 ", 'underlap_in = "wide" ', ["servo.underlap_in", "wide", "a number from -0.05 to 0.05 in"]),
    ("underlap_in = 0.002 ", "underlap_in = 0.2 ", ["servo.underlap_in = 0.2", "from -0.05 to 0.05 in"]),
    ("underlap_in = 0.002 ", "underlap_in = nan ", ["servo.underlap_in = nan", "from -0.05 to 0.05 in"]),
    ("wake_ticks = 10 ", "wake_ticks = 2.5 ", ["loop.wake_ticks = 2.5", "a whole number from 1 to 1000"]),
    ("enabled = false", "enabled = 0", ["stabilizer.enabled = 0", "true or false"]),
    ('shape = "single"', 'shape = "curve A"', ["cam.shape", "curve A", '"single" or "two_slope"']),
    ("lower_alpha = 0.90 ", "lower_alpha = 0.40 ", ["cam.lower_alpha = 0.4", "above cam.upper_alpha = 0.45"]),
    ("x3_in = 4.0 ", "x3_in = 9.0 ", ["start.x3_in = 9", "0 to servo.stroke_in = 8"]),
    ("position_ms = 10 ", "position_ms = -1 ", ["publish.position_ms = -1", "from 0 to 10000 ms"]),
    ("wake_ticks = 10 ", "wake_ticks = 200 ", ["publish.position_ms = 10", "at least the wake period", "200 ticks"]),
    ("relay_piston_rod_diameter_in = 0.996", "relay_piston_rod_diameter_in = 3",
     ["servo.relay_piston_rod_diameter_in = 3", "below servo.relay_piston_diameter_in = 2.494"]),
    ('buses = ["auto"]', "buses = []", ["can.buses", "at least one bus"]),
    ('buses = ["auto"]', "buses = [1]", ["can.buses", "texts in quotes"]),
    ("[supply]", "[supply", []),
    ("pressure_psi = 300.0 ", "pressure_psi = ", []),
    ("underlap_in = 0.002 ", "underlap_in = 0.002\nunderlap_in = 0.002 ", []),
])
def test_configuration_mistakes(configuration, old, new, parts):
    file, line = configuration(old, new)
    text = mistake(*STEADY, "-c", file)
    says(text, *parts)
    # The line of the key that is named: in a wrong table, or of two that do not fit, another than was changed.
    for key, moved in (("frction.coulomb_psi", "coulomb_psi ="), ("publish.position_ms = 10", "position_ms =")):
        if key in text:
            line = file.read_text().split(moved)[0].count("\n") + 1
    if "cannot redefine" in text:
        line += 1
    says(text, f"{file}:{line}: ")


@pytest.mark.parametrize("more", [["--check-config"], []], ids=["checked", "run"])
def test_buses_of_no_known_form(configuration, more):
    file, line = configuration('buses = ["auto"]', 'buses = ["vcan0", "can:can0"]')
    lines = run("run", "-c", file, *more, status=USAGE).stderr.splitlines()
    told = [one for one in lines if " info: " not in one]
    assert [one.split(": expected")[0] for one in told] == [
        f"servohil: {file}:{line}: can.buses: unknown bus '{url}'" for url in ("vcan0", "can:can0")], lines


@pytest.mark.parametrize("setting, parts", [
    ("servo.underlab_in=0.001", ["--set servo.underlab_in=0.001", "did you mean servo.underlap_in?"]),
    ("servo.underlap_in=wide", ["--set servo.underlap_in=wide", "a number from -0.05 to 0.05 in"]),
    ("servo.underlap_in=1", ["--set servo.underlap_in=1", "a number from -0.05 to 0.05 in"]),
    ("servo.underlap_in=", ["--set servo.underlap_in="]),
    ("servo.underlap_in", ["--set servo.underlap_in", "KEY=VALUE"]),
    ("=1", ["--set =1", "KEY=VALUE"]),
])
def test_set_mistakes(setting, parts):
    says(mistake(*STEADY, "--set", setting), *parts)


def test_set_takes_what_toml_takes_and_bare_text(tmp_path):
    for setting in ("servo.underlap_in=.001", "servo.underlap_in=1e-3", "servo.underlap_in=0.001"):
        assert json.loads(run(*STEADY, "--json", "--set", setting).stdout) == json.loads(
            run(*STEADY, "--json", "--set", "servo.underlap_in=0.0010").stdout)
    run(*STEADY, "--set", "cam.shape=two_slope")
    run(*STEADY, "--set", 'cam.shape="two_slope"')
    shutil.copy(CONFIGURATION.parent / "load_curve.csv", tmp_path / "other.csv")
    run(*STEADY, "--set", f"load.file={tmp_path / 'other.csv'}")


def test_missing_files(tmp_path, configuration):
    gone = tmp_path / "gone.toml"
    says(mistake(*STEADY, "-c", gone), str(gone))
    says(mistake(*STEADY, "--set", "load.file=/gone/load.csv"), "load.file = /gone/load.csv", "there is no such file")
    says(mistake(*RUN, "--set", "can.dbc=/gone/bus.dbc"), "can.dbc: /gone/bus.dbc", "there is no such file")
    file, _ = configuration('file = "load_curve.csv"', 'file = "sub/load.csv"')
    says(mistake(*STEADY, "-c", file), str(tmp_path / "sub" / "load.csv"))  # relative to the configuration


def test_a_configuration_here_that_cannot_be_read_is_not_passed_over(tmp_path):
    (tmp_path / "config" / "servohil.toml").mkdir(parents=True)
    done = subprocess.run([PROGRAM, *STEADY], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (USAGE, "servohil: config/servohil.toml: is a directory\n")


@pytest.mark.parametrize("arguments", [
    (*STEADY, "-c"), ("simulate", "--duration", "1", "--p1-file"), ("simulate", "--scenario"), ("dbc", "--decode"),
    ("replay",), ("run", "--from"), ("run", "--set", "can.dbc="), (*STEADY, "--set", "load.file=")],
    ids=lambda arguments: arguments[-1])
def test_files_that_cannot_be_read_say_why(tmp_path, arguments):
    *others, last = arguments
    def with_file(name):
        return (*others, last + name) if last.endswith("=") else (*arguments, name)
    says(mistake(*with_file("x" * 300)), "File name too long")
    says(mistake(*with_file(str(tmp_path / "gone"))), "gone: there is no such file")
    if last != "replay":
        says(mistake(*with_file(str(tmp_path))), "is a directory")


@pytest.mark.parametrize("old, new, parts", [
    ("4.0,103.0", "4.0,much", ['"much" is not a number']),
    ("4.0,103.0", "4.0", ["1 fields, expected 2", "x3_in,p3_psi"]),
    ("4.0,103.0", "4.0,103.0,1", ["3 fields, expected 2"]),
    ("4.0,103.0", "4.0,nan", ["not a number"]),
    ("4.0,103.0", "3.0,103.0", ["x3_in must rise"]),
    ("x3_in,p3_psi", "x,p", ['header is "x,p"', 'expected "x3_in,p3_psi"']),
])
def test_load_table_mistakes(configuration, old, new, parts):
    file, line = configuration(old, new, "load_curve.csv")
    says(mistake(*STEADY, "-c", file.with_name(CONFIGURATION.name)), f"{file}:{line}: ", *parts)


# --- DBC file and bus load -------------------------------------------------------------------------------------------

@pytest.mark.parametrize("old, new, parts", [
    ('[0|300] "psi"', '[0|300] "V"', ["GOV_Command.P1_Demand", '"V"', "expected one of psi, bar"]),
    ('[-1|12.107] "in"', '[-1|12.107] "%"', ["SERVO_Position.X3", '"%"', "expected one of in, mm"]),
    ('[-1|12.107] "in"', '[-1|12.107] "mm"', ["SERVO_Position.X3", "holds -1 to 12.107 mm", "the stroke of 0 to 8 in"]),
    ("SG_ V3 ", "SG_ Speed ", ["SERVO_Position.Speed", "no quantity of the emulator", "X3, V3, Tick"]),
    ("SG_ P1_Demand ", "SG_ P1_Demnd ", ["P1_Demand", "P1_Demnd"]),
    ("SERVO_Status: 8", "SERVO_Stats: 8", ["SERVO_Status", "SERVO_Stats"]),
    ("P3 : 16|16", "P3 : 10|16", ["P3", "P1_Applied"]),
    ("P8 : 48|16", "P8 : 56|16", ["P8", "8 bytes"]),
    ("BO_ 513 SERVO", "BO_ 512 SERVO", ["512"]),
    ("BO_ 514 SERVO_Relay", "BO_ SERVO_Relay", ["SERVO_Relay"]),
])
def test_dbc_mistakes(configuration, old, new, parts):
    file, line = configuration(old, new, DBC.name)
    text = mistake(*RUN, "-c", file.with_name(CONFIGURATION.name))
    says(text, str(file), *parts)
    at = re.search(rf"{re.escape(str(file))}:(\d+)", text)
    if at:  # a message that is missing has no line
        assert abs(int(at[1]) - line) <= 6, text
    else:
        assert "SERVO_Status" in text


def test_bus_load(configuration):
    """Worst-case bits of a frame of 8 bytes: 135, of 4 bytes: 95. 1000 and 100 a second on 125 kbit/s."""
    fast = settings(can__bit_rate_bit_s=125000, publish__position_ms=1)
    done = run(*RUN, *fast, *settings(publish__pressures_ms=0, publish__relay_ms=0, publish__status_ms=0,
                                      publish__bus_ms=0, publish__safety_ms=0, can__command__cycle_ms=1),
               status=USAGE)
    assert done.stderr.count("\n") == 1
    says(done.stderr, "184.0 % of 125000 bit/s", "SERVO_Position every 1 ms", "publish.*_ms")

    half = settings(can__bit_rate_bit_s=125000, publish__position_ms=2, publish__bus_ms=0)
    done = subprocess.run([PROGRAM, *RUN, *half], capture_output=True, text=True, cwd=REPOSITORY, timeout=60)
    assert done.returncode in (OK, 1), done.stderr  # 1: late on a busy machine
    warning = [line for line in done.stderr.splitlines() if "bus load" in line]
    assert len(warning) == 1 and warning[0].startswith("servohil: warning: ")
    says(warning[0], "75.6 % of 125000 bit/s", "70 %")  # 54 + 10.8 + 7.6 + 3 x 1.08

    done = subprocess.run([PROGRAM, *RUN], capture_output=True, text=True, cwd=REPOSITORY, timeout=60)
    says(next(line for line in done.stderr.splitlines() if "bus load" in line), "servohil: info: ", "8.1 % of 500000 bit/s")


# --- simulate --------------------------------------------------------------------------------------------------------

def simulate(*arguments):
    lines = run("simulate", *arguments).stdout.splitlines()
    assert lines[0] == HEADER
    return list(csv.DictReader(io.StringIO("\n".join(lines))))


def test_output_keeps_every_bit():
    """%.17g: each number, read and written again, is the same text; and a second run gives the same bytes."""
    arguments = ("simulate", "--duration", "0.02", "--p1-step", "0.27")
    text = run(*arguments).stdout
    assert text == run(*arguments).stdout
    rows = text.splitlines()[1:]
    assert len(rows) == 201  # the state before the first tick, then one a tick
    for row in rows:
        *numbers, stuck = row.split(",")
        assert stuck in ("0", "1") and len(numbers) == HEADER.count(",")
        for number in numbers:
            assert number == f"{float(number):.17g}"


def test_every_nth_tick_is_a_part_of_all():
    step = ("--duration", "0.02", "--p1-step", "0.27")
    assert simulate(*step, "--every", "7") == simulate(*step)[::7]


def test_p1_file_holds_each_value_from_the_first_tick_at_or_after_its_time(tmp_path):
    file = tmp_path / "p1.csv"
    # At 0.3 ms exactly; between two ticks; and a last value in the middle of the run. The one at 0 would be the rest.
    file.write_text("t_s,p1_psi\n0.0003,31\n0.00055,32.5\n0.001,33\n")
    p1 = [float(row["p1_psi"]) for row in simulate("--duration", "0.0014", "--p1-file", file)]
    rest = float(simulate("--duration", "0.0001")[0]["p1_psi"])
    # Row n: after n ticks, with the P1 of the tick that ended there. The tick from t = 0.3 ms on is the fourth.
    assert p1 == [rest] * 4 + [31.0] * 3 + [32.5] * 4 + [33.0] * 4


def test_p1_file_and_step_agree(tmp_path):
    stepped = simulate("--duration", "0.01", "--p1-step", "0.27")
    file = tmp_path / "p1.csv"
    file.write_text(f"t_s,p1_psi\n0,{stepped[1]['p1_psi']}\n")
    assert simulate("--duration", "0.01", "--p1-file", file) == stepped


@pytest.mark.parametrize("rows, line, parts", [
    ("t,p\n0,30\n", 1, ["expected \"t_s,p1_psi\""]),
    ("t_s,p1_psi\n0,30\n0,31\n", 3, ["t_s must"]),
    ("t_s,p1_psi\n-1,30\n", 2, ["t_s must"]),
    ("t_s,p1_psi\n0,30\n1,high\n", 3, ['"high" is not a number']),
])
def test_p1_file_mistakes(tmp_path, rows, line, parts):
    file = tmp_path / "p1.csv"
    file.write_text(rows)
    says(mistake("simulate", "--duration", "0.01", "--p1-file", file), f"{file}:{line}: ", *parts)


def test_output_file(tmp_path):
    file = tmp_path / "out.csv"
    run("simulate", "--duration", "0.001", "-o", file)
    assert file.read_text() == run("simulate", "--duration", "0.001").stdout
    assert run("simulate", "--duration", "0.001", "-o", "-").stdout == file.read_text()


def test_output_that_cannot_be_written(tmp_path):
    says(mistake("simulate", "--duration", "0.001", "-o", "/dev/full", status=ENVIRONMENT), "/dev/full", "disk full")
    says(mistake("simulate", "--duration", "0.5", "-o", "/dev/full", status=ENVIRONMENT), "/dev/full", "disk full")
    says(mistake("simulate", "--duration", "0.001", "-o", tmp_path / "no" / "such", status=ENVIRONMENT), "no/such")
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([PROGRAM, "simulate", "--duration", "0.5"], stdout=full, stderr=subprocess.PIPE, text=True,
                              cwd=REPOSITORY, timeout=60)
    assert done.returncode == ENVIRONMENT
    says(done.stderr, "standard output", "disk full")


def test_relative_paths_of_the_default_configuration(tmp_path):
    """Anywhere else the configuration beside the program is found, with its load table."""
    done = subprocess.run([PROGRAM, *STEADY, "--json"], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert done.returncode == OK, done.stderr
    assert json.loads(done.stdout) == json.loads(run(*STEADY, "--json").stdout)
