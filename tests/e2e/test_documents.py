"""The documents, held against the checkout: links lead somewhere, and README's commands do what they say."""

import os
import re
import shutil
import subprocess

import pytest
from emulator import PROGRAM, REPOSITORY

DOCUMENTS = sorted(path for path in [*REPOSITORY.glob("*.md"), *REPOSITORY.glob("*/README.md"),
                                     *REPOSITORY.glob("*/*/README.md"), *REPOSITORY.glob("tools/examples/*/README.md")]
                   if "build" not in path.relative_to(REPOSITORY).parts)


def blocks(document):
    """Each block of shell commands: its line, and its text, or None where the document says that it is not run."""
    found = []
    for block in re.finditer(r"^(<!-- not run: .+? -->\n)?```sh\n(.*?)^```$", document, re.MULTILINE | re.DOTALL):
        found.append((document.count("\n", 0, block.start()) + 1, None if block[1] else block[2]))
    return found


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_links_lead_somewhere(path):
    links = re.findall(r"\]\((?!https?:|#)([^)#\s]+)", path.read_text())
    assert not [link for link in links if not (path.parent / link).exists()]


def test_the_readme_is_short():
    assert len((REPOSITORY / "README.md").read_text().splitlines()) <= 150


@pytest.fixture
def checkout(tmp_path):
    """A copy of what the commands read, to write in; `servohil` is on the path."""
    for name in ("config", "tools"):
        shutil.copytree(REPOSITORY / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path, {**os.environ, "PATH": f"{os.path.dirname(PROGRAM)}:{os.environ['PATH']}"}


def run_block(text, checkout):
    folder, environment = checkout
    return subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=folder, env=environment, capture_output=True,
                          text=True, timeout=60)


@pytest.mark.parametrize("path", [path for path in DOCUMENTS if blocks(path.read_text())],
                         ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_commands_do_what_they_say_twice(path, checkout):
    """A reader repeats what went wrong."""
    for line, text in blocks(path.read_text()):
        for _ in range(2 if text is not None else 0):
            done = run_block(text, checkout)
            assert done.returncode == 0, f"{path}:{line}: {done.stdout}{done.stderr}"
        if text is None:
            print(f"{path.relative_to(REPOSITORY)}:{line}: not run")


def test_the_readme_has_commands_that_are_run():
    assert sum(text is not None for _, text in blocks((REPOSITORY / "README.md").read_text())) >= 3


def test_a_wrong_command_is_found(checkout):
    (_, text), = blocks("```sh\nservohil steady --x33 4\n```\n")
    assert run_block(text, checkout).returncode != 0
    assert blocks("<!-- not run: it needs a bench -->\n```sh\nservohil run\n```\n") == [(1, None)]
