"""The architecture, as src/README.md states it: rooms on floors, arrows downward only.

Two readers that know nothing of each other see the same: the text of the #include lines, and what the compiler read.
"""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("SERVOHIL_BUILD") or ROOT / "build/release")
OTHER_TESTS = {"data", "e2e", "fuzz", "package", "support"}  # folders of tests that are no room's


def floors_of(readme):
    """Floor by room, from the table of the rooms."""
    rows = re.findall(r"^\| (\d+) \| `(\w+)` \|", readme, re.MULTILINE)
    assert rows, "src/README.md has no table of rooms"
    return {room: int(floor) for floor, room in rows}


FLOORS = floors_of((ROOT / "src/README.md").read_text())


def may_use(user, used):
    return used == user or FLOORS[used] < FLOORS[user]


def sources(folder):
    return sorted(path for end in ("*.cpp", "*.hpp") for path in folder.rglob(end))


def included(text):
    return re.findall(r'^\s*#\s*include\s+"([^"]+)"', text, re.MULTILINE)


def faults_of_file(room, text):
    """What a file of a room has that the rules forbid, a line each."""
    faults = []
    for header in included(text):
        used = header.split("/")[0]
        if "/" not in header or used not in FLOORS:
            faults.append(f'"{header}": a path from src/ is needed, ROOM/.../FILE')
        elif not may_use(room, used):
            faults.append(f'"{header}": {used} (floor {FLOORS[used]}) is not below {room} (floor {FLOORS[room]})')
    for name in re.findall(r"^namespace servohil(?:::(\w+))?", text, re.MULTILINE):
        if name != room and not re.search(rf"^namespace servohil::{name} {{\n(?:struct|class) \w+;", text, re.MULTILINE):
            faults.append(f"namespace servohil::{name} in room {room}")
    return faults


def test_every_folder_is_a_room_and_every_room_a_folder():
    assert {path.name for path in (ROOT / "src").iterdir() if path.is_dir()} == set(FLOORS)


def test_every_folder_of_tests_is_a_rooms():
    folders = {path.name for path in (ROOT / "tests").iterdir() if path.is_dir() and path.name[0] not in "._"}
    assert folders - OTHER_TESTS <= set(FLOORS)


@pytest.mark.parametrize("room", FLOORS)
def test_includes_and_namespaces_keep_to_the_floors(room):
    found = [f"{path.relative_to(ROOT)}: {fault}" for path in sources(ROOT / "src" / room)
             for fault in faults_of_file(room, path.read_text())]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("room", FLOORS)
def test_libraries_link_lower_floors_only(room):
    linked = set(re.findall(r"servohil::(\w+)", (ROOT / "src" / room / "CMakeLists.txt").read_text()))
    assert not [used for used in linked if used == room or not may_use(room, used)]


def test_the_compiler_read_lower_floors_only():
    known = subprocess.run(["ninja", "-C", BUILD, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    looked_at = set()
    wrong = set()
    for target in known.split("\n\n"):
        room = re.match(r"src/(\w+)/CMakeFiles/", target)
        if not room:
            continue
        looked_at.add(room[1])
        for used in re.findall(rf"^ +(?:{re.escape(str(ROOT))}|\.\./\.\.)/src/(\w+)/", target, re.MULTILINE):
            if not may_use(room[1], used):
                wrong.add((room[1], used))
    assert len(looked_at) > len(FLOORS) - 3, f"{BUILD} has objects of {sorted(looked_at)} only"
    assert not wrong


def test_each_kind_of_fault_is_found():
    assert faults_of_file("model", '#include "model/step.hpp"\nnamespace servohil::model {\n') == []
    assert faults_of_file("model", '#include "fault/schedule.hpp"\n')
    assert faults_of_file("control", '#include "scenario/reader.hpp"\n')
    assert faults_of_file("model", '#include "step.hpp"\n')
    assert faults_of_file("model", "namespace servohil::fault {\n")
