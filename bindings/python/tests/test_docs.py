"""The tour of docs/python.md is run as it stands, and its pictures are what it makes."""

import io
import re
import sys

import numpy as np
import pytest
from conftest import SOURCE, run

import knead

PAGE = SOURCE / "docs/python.md"
PICTURES = ("tool", "pulled", "finger", "remeshed")


@pytest.fixture(scope="module")
def toured(tmp_path_factory):
    """A folder in which all blocks of the page have been run; what they printed; whether there is OpenGL."""
    folder = tmp_path_factory.mktemp("tour")
    run("make", "hand", "-n", 20000, "-q", "-o", folder / "hand.ply")
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.M | re.S)
    assert len(blocks) >= 10
    has_opengl = True
    try:
        knead.render([[0, 0, 0], [1, 1, 1]], size=(16, 16))
    except knead.Unavailable:
        has_opengl = False
    text = "\n".join(blocks)
    if "matplotlib" in text:
        matplotlib = pytest.importorskip("matplotlib")
        matplotlib.use("Agg")
    if not has_opengl:
        text = re.sub(r"^save\(.*\)$", "", text, flags=re.M)
    printed, before = io.StringIO(), sys.stdout
    monkey = pytest.MonkeyPatch()
    monkey.chdir(folder)
    sys.stdout = printed
    try:
        exec(compile(text, str(PAGE), "exec"), {"__name__": "tour"})
    finally:
        sys.stdout = before
        monkey.undo()
    return folder, printed.getvalue(), has_opengl


def test_the_tour_runs(toured):
    folder, printed, _ = toured
    lines = printed.splitlines()
    assert lines[0].startswith("<knead.Shape: ply, ")
    assert '"inner" must be' in printed or "inner" in printed
    run("deform", folder / "hand.ply", folder / "finger.knead", "-q", "-o", folder / "theirs.ply")
    assert (folder / "finger.ply").read_bytes() == (folder / "theirs.ply").read_bytes()


@pytest.mark.parametrize("name", PICTURES)
def test_its_pictures_are_those_of_the_page(toured, name):
    folder, _, has_opengl = toured
    if not has_opengl:
        pytest.skip("no OpenGL")
    image = pytest.importorskip("matplotlib.image")
    pytest.importorskip("PIL")
    made = image.imread(folder / f"{name}.png")[..., :3] * 255
    shown = image.imread(SOURCE / f"docs/images/python/{name}.jpg")[..., :3]
    assert made.shape == shown.shape
    assert np.abs(made - shown).mean() < 3
