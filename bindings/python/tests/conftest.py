"""Shapes and sessions that the tests share."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import knead

SOURCE = pathlib.Path(os.environ.get("KNEAD_SOURCE", pathlib.Path(__file__).parents[3]))
COMMAND = os.environ.get("KNEAD", str(SOURCE / "build/release/knead"))


def run(*arguments):
    """Runs the command; returns its standard output."""
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def make(kind, path, vertices):
    run("make", kind, "-n", vertices, "-o", path, "-q")
    return knead.read(path)


@pytest.fixture(scope="session")
def files(tmp_path_factory):
    return tmp_path_factory.mktemp("shapes")


@pytest.fixture(scope="session")
def sphere(files):
    return make("sphere", files / "sphere.ply", 4000)


@pytest.fixture(scope="session")
def hand(files):
    return make("hand", files / "hand.ply", 8000)


@pytest.fixture
def pull():
    return knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5)


@pytest.fixture
def session(pull):
    bend = knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[1, 0, 0], width=1.0, angle_deg=70)
    return knead.Session([pull, bend])


def bits(array):
    return np.ascontiguousarray(array).tobytes()
