"""tools/vcan-guest, as its user sees it: any command, unchanged, in a guest with a real SocketCAN stack.

The kernel is built by the first run on a machine (3 to 5 min); cached, this file takes about 20 s. It needs a host: in
a guest it does not apply. Nothing here waits for a length of time: it waits for lines, files, or the end of processes.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import pytest

if os.environ.get("SERVOHIL_GUEST"):
    pytest.skip("vcan-guest is tested from outside of a guest", allow_module_level=True)

TOOLS = Path(__file__).resolve().parents[2] / "tools"
VCAN_GUEST = TOOLS / "vcan-guest"
PYTHON = "/usr/bin/python3"
BUSY = "echo ready; while :; do :; done"  # in virtual time, never ends: no clock, no wait
PATIENCE_S = 60  # real seconds after which a test has failed; 100 times what a run takes


@pytest.fixture(scope="session", autouse=True)
def built_guest():
    result = subprocess.run([VCAN_GUEST, "true"], capture_output=True, text=True, timeout=3600)
    assert result.returncode == 0, result.stderr


def run(*command, options=(), **keywords):
    keywords = {"capture_output": True, "timeout": PATIENCE_S, **keywords}
    return subprocess.run([VCAN_GUEST, *options, "--", *command], **keywords)


def python(program, *arguments, **keywords):
    return run(PYTHON, "-c", program, *arguments, **keywords)


def wait_until(condition, what):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.002)


# --- the command: its arguments, surroundings, output and exit status -------------------------------------------------


@pytest.mark.parametrize("status", [0, 1, 42, 125, 255])
def test_exit_status_is_the_commands(status):
    assert run("sh", "-c", f"exit {status}").returncode == status


def test_command_killed_by_a_signal_gives_128_and_the_signal():
    assert run("sh", "-c", "kill -9 $$").returncode == 128 + 9


@pytest.mark.parametrize("command, status, message", [("no-such-command", 127, b"not found"), ("/", 126, b"denied")])
def test_command_that_cannot_run(command, status, message):
    result = run(command)
    assert result.returncode == status
    assert result.stderr.count(b"\n") == 1 and command.encode() in result.stderr and message in result.stderr


def test_arguments_arrive_as_they_are():
    odd = ["", " ", "a  b", "'", '"', "$HOME", "*", "`id`", "\\", "line\nbreak", "tab\t", "-x", "--", "--out", "é",
           "a=b"]
    result = python("import json, sys; print(json.dumps(sys.argv[1:]))", *odd)
    assert json.loads(result.stdout) == odd


def test_streams_are_separate_whole_and_binary():
    # 5 MB each with every byte value: NULs, and the \n that a terminal would turn into \r\n
    block = bytes(range(256)) * 80
    result = python(
        "import sys\n"
        "block = bytes(range(256)) * 80\n"
        "for i in range(256):\n"
        "    sys.stdout.buffer.write(block)\n"
        "    sys.stderr.buffer.write(block[::-1])\n"
    )
    assert result.returncode == 0
    assert result.stdout == block * 256
    assert result.stderr == block[::-1] * 256


def test_order_across_the_two_streams_is_kept():
    result = run("bash", "-c", "for i in {1..500}; do echo out $i; echo err $i >&2; done", stdout=subprocess.PIPE,
                 stderr=subprocess.STDOUT, capture_output=False)
    assert result.stdout.decode() == "".join(f"out {i}\nerr {i}\n" for i in range(1, 501))


def test_output_arrives_while_the_command_runs():
    with subprocess.Popen([VCAN_GUEST, "sh", "-c", BUSY], stdout=subprocess.PIPE) as guest:
        assert guest.stdout.readline() == b"ready\n"
        guest.terminate()


def test_reader_that_leaves_early_ends_the_guest(tmp_path):
    guest = subprocess.Popen([VCAN_GUEST, "yes"], stdout=subprocess.PIPE, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert guest.stdout.readline() == b"y\n"
    guest.stdout.close()
    assert guest.wait(PATIENCE_S) == 128 + signal.SIGPIPE
    assert not list(tmp_path.iterdir())


def test_process_left_behind_by_the_command_does_not_hold_the_guest():
    result = run("sh", "-c", "while :; do :; done & echo done")
    assert (result.returncode, result.stdout) == (0, b"done\n")


def test_standard_input_is_empty_unless_asked_for():
    data = bytes(range(256)) * 1000
    assert run("cat", input=data).stdout == b""
    assert run("cat", input=data, options=["--stdin"]).stdout == data


def test_environment_is_clean_but_for_what_is_passed():
    caller = {**os.environ, "PASSED": "as\nit is", "FORGOTTEN": "x"}
    result = python("import json, os; print(json.dumps(dict(os.environ)))", env=caller,
                    options=["--env", "PASSED", "--env=GIVEN=a=b c", "--env", "ABSENT"])
    inside = json.loads(result.stdout)
    assert inside["PASSED"] == "as\nit is" and inside["GIVEN"] == "a=b c" and "ABSENT" not in inside
    assert inside["SERVOHIL_GUEST"] == "1" and inside["GUEST_OUT"] == "/run/out" and "FORGOTTEN" not in inside
    assert run("env", "A=b", "sh", "-c", "echo $A").stdout == b"b\n"


def test_files_of_the_host_are_there_and_read_only(tmp_path):
    folder = tmp_path / "with a blank"
    folder.mkdir()
    (folder / "file").write_text("host")
    elsewhere = Path("/usr")  # /tmp is another matter, see below
    result = run("sh", "-c", f"cat file; pwd; touch '{elsewhere}/new'", cwd=folder)
    assert result.stdout.decode() == f"host{folder}\n"
    assert result.returncode == 1 and b"Read-only file system" in result.stderr
    assert not (elsewhere / "new").exists()


def test_tmp_shows_the_hosts_files_and_forgets_new_ones():
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        (Path(folder) / "file").write_text("host")
        result = run("sh", "-c", f"echo guest >> {folder}/file; touch {folder}/new; cat {folder}/file")
        assert result.stdout == b"hostguest\n"
        assert [f.read_text() for f in Path(folder).iterdir()] == ["host"]


def test_output_folder_is_writable_at_the_same_path(tmp_path):
    out = tmp_path / "made here"
    result = run("sh", "-c", 'printf guest > "$GUEST_OUT/file"; echo "$GUEST_OUT"', options=["--out", out])
    assert result.returncode == 0, result.stderr
    assert result.stdout.decode() == f"{out}\n"
    assert (out / "file").read_text() == "guest"
    assert run("sh", "-c", "echo x > $GUEST_OUT/f && cat $GUEST_OUT/f").stdout == b"x\n"  # the temporary one


@pytest.mark.parametrize("arguments", [[], ["--bad", "true"], ["--timeout"], ["--timeout", "1.5", "true"],
                                       ["--memory", "lots", "true"], ["--memory", "8M", "true"],
                                       ["--env", "1=2", "true"], ["--out", "/", "true"]])
def test_wrong_usage_is_125_and_says_so(arguments):
    result = subprocess.run([VCAN_GUEST, *arguments], capture_output=True, timeout=PATIENCE_S)
    assert result.returncode == 125 and result.stdout == b"" and result.stderr


def test_guest_in_a_guest_is_refused():
    result = run(VCAN_GUEST, "true")
    assert result.returncode == 125 and b"already a guest" in result.stderr


# --- CAN -------------------------------------------------------------------------------------------------------------

CANDUMP_READY = "until grep -qs vcan0 /proc/net/can/rcvlist_all; do sleep 0.001; done"


def test_vcan0_is_up():
    link = json.loads(run("ip", "-j", "link", "show", "vcan0").stdout)[0]
    assert link["link_type"] == "can" and "UP" in link["flags"]


def test_candump_sees_what_cansend_sends():
    result = run("bash", "-c", f"candump -L -n 2 vcan0 & {CANDUMP_READY}; cansend vcan0 123#01F4; "
                               "cansend vcan0 1ABCDEF0##5DEADBEEF; wait")
    # 5: bit-rate switch, and the flag by which the kernel marks CAN FD
    assert [line.split()[2] for line in result.stdout.decode().splitlines()] == ["123#01F4", "1ABCDEF0##5DEADBEEF"]


def test_python_can_sends_and_receives():
    result = python(
        "import can\n"
        "a, b = (can.Bus('vcan0', interface='socketcan') for _ in 'ab')\n"
        "a.send(can.Message(arbitration_id=0x12B, data=[0x01, 0xF4], is_extended_id=False))\n"
        "m = b.recv(1)\n"
        "print(hex(m.arbitration_id), m.data.hex(), b.recv(1))\n"
        "a.shutdown(), b.shutdown()\n"
    )
    assert result.stdout == b"0x12b 01f4 None\n", result.stderr


def test_controllers_are_the_other_guests(tmp_path):
    """Another machine, the same manners."""
    elsewhere = Path("/usr")
    script = (f"ip -br link; cat; echo $EMPTY $PWD; touch {elsewhere}/new; echo x > /tmp/new; "
              f"printf guest > $GUEST_OUT/file; exit 42")
    result = run("sh", "-c", script, cwd=tmp_path, input=b"a\0b\n",
                 options=["--controllers", "--stdin", "--env", "EMPTY=given", "--out", tmp_path / "o,ut"])
    assert result.returncode == 42, result.stderr
    links = result.stdout.decode().splitlines()
    assert [line.split()[0] for line in links[:4]] == ["lo", "can0", "can1", "vcan0"]
    assert result.stdout.endswith(f"a\0b\ngiven {tmp_path}\n".encode())
    assert b"Read-only file system" in result.stderr and not Path("/tmp/new").exists()
    assert (tmp_path / "o,ut/file").read_text() == "guest"


# --- time ------------------------------------------------------------------------------------------------------------


def test_waiting_costs_nothing_in_virtual_time():
    start = time.monotonic()
    result = run("bash", "-c", "a=$EPOCHREALTIME; sleep 3600; b=$EPOCHREALTIME; echo ${a%.*} $((${b%.*} - ${a%.*}))")
    # 2000000000 s is when every command starts
    assert result.stdout == b"2000000000 3600\n"
    assert time.monotonic() - start < PATIENCE_S


def test_runs_in_virtual_time_are_identical():
    # a sender every 1 ms for 2 s, and after a long wait (the kernel's own timers had their turn), logged with times
    sender = ("import can, os, sys, time\n"
              "bus = can.Bus('vcan0', interface='socketcan')\n"
              "for i in range(2000):\n"
              "    if i == 1000: time.sleep(1000)\n"
              "    bus.send(can.Message(arbitration_id=i % 0x800, data=os.urandom(8), is_extended_id=False))\n"
              "    time.sleep(0.001)\n"
              "print(time.time_ns(), hash('x'), file=sys.stderr)\n"
              "bus.shutdown()\n")
    script = f'candump -L -n 2000 vcan0 & {CANDUMP_READY}; {PYTHON} -c "$1"; wait'
    runs = [run("bash", "-c", script, "sender", sender) for _ in range(3)]
    assert len(runs[0].stdout.splitlines()) == 2000
    assert len({r.stdout for r in runs}) == 1
    assert len({r.stderr for r in runs}) == 1


def test_real_time_runs_of_the_emulator_repeat():
    """Each kind of guest_determinism.py, short."""
    tool = TOOLS.parent / "tests" / "e2e" / "guest_determinism.py"
    result = subprocess.run([tool, "--runs", "2", "--duration", "0.3"], capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result
    hashes = re.findall(r"hashes 2 x (\w+); late ticks 0; commands (\d+)", result.stdout)
    assert len(hashes) == 3 and hashes[0] == hashes[2] != hashes[1], "answering and recorded are one, clocked another"
    assert all(int(commands) >= 29 for _, commands in hashes)


def test_real_time_is_the_hosts():
    before = time.time()
    inside = float(run("date", "+%s.%N", options=["--real-time"]).stdout)
    # the guest's clock counts from a whole second of the host's
    assert before - 1.1 < inside < time.time() + 0.1


# --- the end ---------------------------------------------------------------------------------------------------------


def processes_below(parent):
    """(pid, start time) of every process that descends from this one."""
    children = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append((int(stat.parent.name), fields[19]))
    found, new = [], [(parent, "")]
    while new:
        new = [child for pid, _ in new for child in children.get(pid, [])]
        found += new
    return found


def lives(process):
    try:
        fields = Path(f"/proc/{process[0]}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return False
    return fields[19] == process[1] and fields[0] not in "ZX"


@pytest.mark.parametrize("how, options", [(signal.SIGINT, []), (signal.SIGTERM, []), (signal.SIGHUP, []),
                                          (signal.SIGKILL, []), (signal.SIGKILL, ["--controllers"])])
def test_killed_runner_leaves_nothing(tmp_path, how, options):
    def take_signals():  # whatever this process was told to ignore (nohup)
        for one in (signal.SIGINT, signal.SIGHUP):
            signal.signal(one, signal.SIG_DFL)

    guest = subprocess.Popen([VCAN_GUEST, *options, "sh", "-c", BUSY], stdout=subprocess.PIPE, preexec_fn=take_signals,
                             env={**os.environ, "TMPDIR": str(tmp_path)})
    assert guest.stdout.readline() == b"ready\n"
    processes = processes_below(guest.pid)
    assert len(processes) >= 3  # the relay, the leash, the guest's kernel (and where that is UML, its processes)
    guest.send_signal(how)
    assert guest.wait(PATIENCE_S) == -how
    guest.stdout.close()
    if how == signal.SIGKILL:  # the others end only when all is gone
        wait_until(lambda: not any(map(lives, processes)) and not list(tmp_path.iterdir()), "the guest's end")
    assert [p for p in processes if lives(p)] == []
    assert list(tmp_path.iterdir()) == []


def test_timeout_is_125_with_a_reason(tmp_path):
    result = run("sh", "-c", BUSY, options=["--timeout", "1"], env={**os.environ, "TMPDIR": str(tmp_path)})
    assert result.returncode == 125 and result.stdout == b"ready\n"
    assert result.stderr.count(b"\n") == 1 and b"after 1 s of real time" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_guest_that_dies_is_125_with_a_reason():
    result = python("import ctypes; ctypes.CDLL(None).reboot(0x4321FEDC)")  # power off
    assert result.returncode == 125 and result.stderr.count(b"\n") == 1 and b"guest ended" in result.stderr


def test_concurrent_runs_do_not_meet():
    def start(i):
        return subprocess.Popen([VCAN_GUEST, "sh", "-c", f"sleep 1; echo {i}; exit {i}"], stdout=subprocess.PIPE)

    for i, guest in enumerate([start(i) for i in range(6)]):
        assert guest.communicate(timeout=PATIENCE_S)[0] == b"%d\n" % i and guest.returncode == i


# --- the host's processor ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def host_xstate(tmp_path_factory):
    """What the guest kernel does with the host's registers, on hosts that are made up."""
    def build(headers):
        program = tmp_path_factory.mktemp("xstate") / "host_xstate"
        subprocess.run(["gcc", "-Wall", "-Wextra", "-Werror", "-O1", "-fsanitize=address,undefined", "-I", headers,
                        "-o", program, Path(__file__).with_name("host_xstate.c")], check=True)
        return lambda bytes: subprocess.run([program, str(bytes)], capture_output=True, text=True)
    return build


# x87 and SSE only, AVX, what the kernel keeps (AVX-512 and protection keys), and AMX
@pytest.mark.parametrize("size", [576, 832, 2696, 11008])
def test_registers_of_any_host_are_restored(host_xstate, size):
    result = host_xstate(TOOLS / "guest")(size)
    assert result.returncode == 0, result.stdout


def test_more_registers_than_there_is_room_for_are_told(host_xstate):
    result = host_xstate(TOOLS / "guest")(16384)
    assert result.returncode == 3 and "16383 bytes (tools/guest/host-xstate.h)" in result.stdout


@pytest.mark.parametrize("line, instead", [("iov_len = host_xstate_bytes", "iov_len = kept_bytes"),
                                           ("&= ~HOST_XSTATE_TILES", "&= ~0UL"),
                                           ("memset(host_xstate, 0, sizeof(host_xstate))", "(void)0")])
def test_what_the_host_refuses_is_found(host_xstate, tmp_path, line, instead):
    text = (TOOLS / "guest/host-xstate.h").read_text()
    assert line in text
    (tmp_path / "host-xstate.h").write_text(text.replace(line, instead))
    assert host_xstate(tmp_path)(11008).returncode == 1


def test_processes_keep_their_own_vector_registers():
    program = ("import numpy; x = numpy.arange({0}, {0} + 4096, dtype=float)\nfor _ in range(300):\n"
               "    y = numpy.sqrt(x * x); assert (y == x).all()\nprint('same')")
    both = " & ".join(f'{PYTHON} -c "{program.format(start)}"' for start in (1, 100000))
    result = run("sh", "-c", f"{both}; wait")
    assert (result.returncode, result.stdout) == (0, b"same\nsame\n"), result.stderr


# --- the cache -------------------------------------------------------------------------------------------------------


def cached(pattern):
    return max((Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "servohil").glob(pattern),
               key=lambda f: f.stat().st_mtime)


@pytest.fixture
def fresh(tmp_path):
    """A copy of the tools with an empty cache, where building the kernel takes a copy of the real one."""
    shutil.copytree(TOOLS / "guest", tmp_path / "tools/guest")
    shutil.copy(VCAN_GUEST, tmp_path / "tools")
    stubs = tmp_path / "bin"
    stubs.mkdir()
    (stubs / "apt-cache").write_text("#!/bin/sh\necho '  Candidate: 6.1.0-1'\n")
    (stubs / "apt-cache").chmod(0o755)
    build = tmp_path / "tools/guest/build-kernel.sh"
    build.write_text(f"#!/bin/sh\necho built >> {tmp_path}/builds\ncp {cached('guest-*/linux')} $2/linux\n")
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache"), "PATH": f"{stubs}:{os.environ['PATH']}"}
    return tmp_path, build, environment


def test_two_first_runs_at_once_build_once(fresh):
    folder, _, environment = fresh
    runs = [subprocess.Popen([folder / "tools/vcan-guest", "echo", "ran"], env=environment, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE) for _ in range(2)]
    for guest in runs:
        out, err = guest.communicate(timeout=PATIENCE_S)
        assert (guest.returncode, out) == (0, b"ran\n"), err
    assert (folder / "builds").read_text() == "built\n"
    again = subprocess.run([folder / "tools/vcan-guest", "true"], env=environment, capture_output=True)
    assert (again.returncode, again.stderr) == (0, b"")


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_killed_build_leaves_no_half_result(fresh, how):
    folder, build, environment = fresh
    build.write_text("#!/bin/sh\necho half > $2/linux\nexec sleep infinity\n")
    guest = subprocess.Popen([folder / "tools/vcan-guest", "true"], env=environment, stderr=subprocess.PIPE)
    cache = folder / "cache/servohil"
    wait_until(lambda: list(cache.glob("build.*/linux")), "the build's start")
    guest.send_signal(how)
    assert guest.wait(PATIENCE_S) == -how
    wait_until(lambda: not list(cache.glob("build.*")), "the scratch folder's end")
    assert not list(cache.glob("*/linux"))


def test_without_a_candidate_the_cached_kernel_serves(fresh):
    folder, _, environment = fresh
    (folder / "bin/apt-cache").write_text("#!/bin/sh\necho '  Candidate: (none)'\n")
    command = [folder / "tools/vcan-guest", "--build"]
    none = subprocess.run(command, env=environment, capture_output=True)
    assert none.returncode == 125 and none.stderr.count(b"\n") == 1 and b"apt-get update" in none.stderr
    shutil.copytree(folder / "bin", folder / "online")
    (folder / "online/apt-cache").write_text("#!/bin/sh\necho '  Candidate: 6.1.0-1'\n")
    online = {**environment, "PATH": f"{folder}/online:{environment['PATH']}"}
    assert subprocess.run(command, env=online, capture_output=True).returncode == 0
    assert subprocess.run(command, env=environment, capture_output=True).returncode == 0


def test_failed_build_shows_its_end(fresh):
    folder, build, environment = fresh
    build.write_text("#!/bin/sh\necho the reason >&2\nexit 1\n")
    result = subprocess.run([folder / "tools/vcan-guest", "true"], env=environment, capture_output=True)
    assert result.returncode == 125 and b"the reason\nvcan-guest: " in result.stderr
    assert [f.name for f in (folder / "cache/servohil").glob("*") if not f.name.startswith("guest-")] == ["lock"]


def test_guest_that_cannot_start_here_says_why_and_is_not_kept(fresh):
    folder, build, environment = fresh
    build.write_text("#!/bin/sh\necho '#!/bin/sh\necho \"<0>Kernel panic - not syncing: made up\"' > $2/linux\n"
                     "chmod +x $2/linux\n")
    result = subprocess.run([folder / "tools/vcan-guest", "--build"], env=environment, capture_output=True, text=True)
    last = result.stderr.splitlines()[-1]
    assert result.returncode == 125 and "Kernel panic - not syncing: made up" in last
    assert os.uname().release in last and "--controllers" in last
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    assert model is None or model[1] in last
    assert not list((folder / "cache/servohil").glob("*/linux"))


def test_missing_build_tools_are_named_with_the_remedy(fresh):
    folder, _, environment = fresh
    tools = folder / "few"
    tools.mkdir()
    for program in Path("/usr/bin").iterdir():
        if program.name not in ("gcc", "flex", "bison"):
            (tools / program.name).symlink_to(program)
    result = subprocess.run([folder / "tools/vcan-guest", "true"], env={**environment, "PATH": str(tools)},
                            capture_output=True)
    assert result.returncode == 125 and result.stderr.count(b"\n") == 1
    assert b"gcc" in result.stderr and b"tools/deps.sh guest" in result.stderr and b"apt-get install" in result.stderr


def test_missing_emulator_is_named_with_the_remedy(fresh):
    folder, _, environment = fresh
    tools = folder / "few"
    tools.mkdir()
    for program in Path("/usr/bin").iterdir():
        if not program.name.startswith("qemu-system"):
            (tools / program.name).symlink_to(program)
    result = subprocess.run([folder / "tools/vcan-guest", "--controllers", "true"],
                            env={**environment, "PATH": str(tools)}, capture_output=True)
    assert result.returncode == 125 and result.stderr.count(b"\n") == 1
    assert b"qemu-system-x86_64; run tools/deps.sh controllers" in result.stderr


def test_cache_that_cannot_be_written_is_named(fresh):
    folder, _, environment = fresh
    result = subprocess.run([folder / "tools/vcan-guest", "true"], env={**environment, "XDG_CACHE_HOME": "/proc"},
                            capture_output=True)
    assert result.returncode == 125 and result.stderr.count(b"\n") == 1 and b"XDG_CACHE_HOME" in result.stderr


@pytest.mark.skipif(os.geteuid() != 0, reason="not root: then every test here is this one")
def test_needs_no_root(fresh):
    folder, _, environment = fresh
    with tempfile.TemporaryDirectory(dir="/tmp") as home:  # where nobody can go, unlike tmp_path
        os.chmod(home, 0o777)
        shutil.copytree(folder / "tools", f"{home}/tools")
        shutil.copy(cached("guest-*/linux"), f"{home}/linux")
        Path(f"{home}/tools/guest/build-kernel.sh").write_text(f"#!/bin/sh\ncp {home}/linux $2/linux\n")
        shutil.copytree(folder / "bin", f"{home}/bin")
        result = subprocess.run(
            ["runuser", "-u", "nobody", "--", "env", f"XDG_CACHE_HOME={home}/cache", f"TMPDIR={home}",
             f"PATH={home}/bin:/usr/bin:/bin", f"{home}/tools/vcan-guest", "--out", f"{home}/out", "--",
             "sh", "-c", "id -u; ip -br link show vcan0; echo x > $GUEST_OUT/f"],
            cwd="/", capture_output=True, text=True, timeout=PATIENCE_S)
        assert result.returncode == 0, result.stderr
        assert result.stdout.startswith("0\nvcan0 ")
        assert Path(f"{home}/out/f").read_text() == "x\n"
