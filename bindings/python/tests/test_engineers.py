"""The hour of docs/engineers.md is run as it stands: commands by a shell, Python in one module, in the order of the page."""

import io
import os
import pathlib
import re
import subprocess
import sys

import pytest
from conftest import COMMAND, SOURCE

import knead  # noqa: F401

PAGE = SOURCE / "docs/engineers.md"


@pytest.fixture(scope="module")
def hour(tmp_path_factory):
    """The folder in which all blocks of the page have been run, and what the blocks of Python printed."""
    folder = tmp_path_factory.mktemp("hour")
    path = f"{pathlib.Path(COMMAND).parent}{os.pathsep}{os.environ['PATH']}"
    names, printed = {"__name__": "hour"}, io.StringIO()
    blocks = re.findall(r"^```(sh|python)\n(.*?)^```$", PAGE.read_text(), re.M | re.S)
    assert [kind for kind, _ in blocks].count("sh") >= 5 and [kind for kind, _ in blocks].count("python") >= 4
    monkey = pytest.MonkeyPatch()
    monkey.chdir(folder)
    monkey.setattr(sys, "stdout", printed)
    try:
        for kind, text in blocks:
            if kind == "python":
                exec(compile(text, str(PAGE), "exec"), names)
            else:
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], env={**os.environ, "PATH": path},
                                      capture_output=True, text=True)
                assert done.returncode == 0, text + done.stderr
                assert done.stderr == "", text
    finally:
        monkey.undo()
    return folder, printed.getvalue()


def test_the_batch_is_there(hour):
    folder, _ = hour
    assert len(list((folder / "variants").glob("*.stl"))) == 20
    lines = (folder / "variants/results.csv").read_text().splitlines()
    assert len(lines) == 21 and all(line.endswith(",") for line in lines[1:])


def test_five_steps_find_the_values(hour):
    _, printed = hour
    assert re.search(r"^4 \{'angle': (63\.0000|62\.99999)\d*, 'bump': 0\.1[67]", printed, re.M)


def test_no_cell_inverts(hour):
    _, printed = hour
    assert len(re.findall(r"'inverted': 0", printed)) == 4
