"""The same session by the command and by Python gives the same bits, for every session in examples/ without walls."""

import json
import os
import pathlib
import shutil

import numpy as np
import pytest
from conftest import SOURCE, bits, run

import knead

KINDS = ("sphere", "box", "cylinder", "torus", "hand", "crater", "knot", "letter-y")
MESHES = pathlib.Path(os.environ.get("KNEAD_TEST_MESHES", "/nonexistent"))
SESSIONS = [p for p in sorted((SOURCE / "examples").rglob("*.knead")) if "walls" not in json.loads(p.read_text().splitlines()[0])]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("examples")


def provide(name, folder):
    """Makes the shape of that name, or takes a real mesh."""
    if (folder / name).exists():
        return
    kind = pathlib.Path(name).stem.split("_")[0]
    if kind in KINDS and not (kind == "hand" and "50k" in name):
        run("make", kind, "-n", 24000 if kind == "crater" else 6000, "-q", "-o", folder / name)
    elif (MESHES / name).exists():
        shutil.copy(MESHES / name, folder / name)
    else:
        pytest.skip(f"{name} is absent")


@pytest.mark.parametrize("path", SESSIONS, ids=[str(p.relative_to(SOURCE / "examples")) for p in SESSIONS])
def test_same_bits_as_the_command(path, folder):
    here = folder / path.name
    shutil.copy(path, here)
    names = [json.loads(line).get("mesh") for line in here.read_text().splitlines()]
    for name in filter(None, names):
        provide(name, folder)
    session = knead.Session.read(here)
    source = folder / session.mesh
    shape = knead.read(source)
    run("deform", source, here, "-q", "--keep-mesh", "--digits", "shortest", "-o", folder / "theirs.ply")
    theirs = knead.read(folder / "theirs.ply").vertices
    try:
        ours = knead.deform(shape.vertices, session, shape.faces)
    except knead.InvalidInput as error:
        assert "remesh" in str(error)
        return
    kind = np.float32 if (theirs.astype(np.float32) == theirs).all() else np.float64
    assert bits(ours.astype(kind)) == bits(theirs.astype(kind))
    if any(stroke.tool == "relax" for stroke in session):
        return
    flow = knead.Flow(session.resolve(shape.vertices, shape.faces))
    if not any(getattr(stroke, "radius", None) for stroke in session if stroke.tool in ("bend", "twist")):
        assert bits(flow(shape.vertices)) == bits(ours)
