"""Gaussian splats: files deform as by the command, arrays as files, and centres alone are not moved without a word."""

import numpy as np
import pytest
from conftest import run

import knead

BEND = knead.Bend(center=(0, 0, 0), axis=(0, 1, 0), normal=(0, 0, 1), width=1, angle_deg=70)


@pytest.fixture
def splats():
    numbers = np.random.default_rng(3)
    turns = numbers.normal(size=(200, 4))
    arrays = [numbers.uniform(-1, 1, (200, 3)), numbers.uniform(-9, -5.5, (200, 3)), turns / np.linalg.norm(turns, axis=1)[:, None]]
    return knead.Splats(*(a.astype(np.float32) for a in (*arrays, 0.2 * numbers.normal(size=(200, 16, 3)), numbers.normal(size=200))))


def test_a_file_is_deformed_as_by_the_command(tmp_path, splats):
    splats.write(tmp_path / "capture.ply")
    knead.Session([BEND]).write(tmp_path / "bend.knead")
    run("deform", tmp_path / "capture.ply", tmp_path / "bend.knead", "-o", tmp_path / "bent.ply", "-q")
    shape = knead.deform_mesh(knead.read(tmp_path / "capture.ply"), BEND)
    shape.write(tmp_path / "own.ply")
    assert (tmp_path / "own.ply").read_bytes() == (tmp_path / "bent.ply").read_bytes()
    again = knead.deform_mesh(shape, BEND, inverse=True).splats
    for name in ("means", "scales", "harmonics"):
        assert np.abs(getattr(again, name) - getattr(splats, name)).max() < 1e-5
    (tmp_path / "both").mkdir()
    run("make", "sphere", "-n", 500, "-o", tmp_path / "proxy.ply", "-q")
    run("deform", tmp_path / "capture.ply", tmp_path / "bend.knead", "--also", tmp_path / "proxy.ply", "-o", tmp_path / "both", "--keep-mesh", "-q")
    assert (tmp_path / "both/capture.ply").read_bytes() == (tmp_path / "bent.ply").read_bytes()


def test_arrays_are_those_of_the_file(tmp_path, splats):
    splats.write(tmp_path / "capture.ply")
    read = knead.read(tmp_path / "capture.ply").splats
    for name in ("means", "scales", "rotations", "harmonics", "opacities"):
        assert (getattr(read, name) == getattr(splats, name)).all(), name
    of_file = knead.deform_mesh(knead.read(tmp_path / "capture.ply"), BEND).splats
    of_arrays = knead.deform_mesh(splats, BEND)
    for name in ("means", "scales", "rotations", "harmonics", "opacities"):
        assert (getattr(of_arrays, name) == getattr(of_file, name)).all(), name
        assert getattr(of_arrays, name).dtype == np.float32
    assert (of_arrays.opacities == splats.opacities).all() and (of_arrays.scales != splats.scales).any()
    bare = knead.deform_mesh(knead.Splats(splats.means.astype(float), splats.scales, splats.rotations), BEND)
    assert bare.harmonics is None and bare.means.dtype == np.float64 and np.abs(bare.means - of_arrays.means).max() < 1e-6


def test_glb_files_hold_them(tmp_path, splats):
    splats.write(tmp_path / "capture.glb")
    shape = knead.deform_mesh(knead.read(tmp_path / "capture.glb"), BEND)
    shape.write(tmp_path / "bent.glb")
    found, expected = knead.read(tmp_path / "bent.glb").splats, knead.deform_mesh(splats, BEND)
    assert len(found) == len(expected)
    for name, error in (("means", 1e-6), ("scales", 1e-5), ("harmonics", 1e-5), ("opacities", 1e-5)):
        assert np.abs(getattr(found, name) - getattr(expected, name)).max() < error, name


class Tensor:
    """What knead sees of a tensor of PyTorch with a gradient on a GPU."""

    def __init__(self, values):
        self.values = values

    def __len__(self):
        return len(self.values)

    def detach(self):
        return self

    cpu = detach

    def numpy(self):
        return self.values

    def new_tensor(self, values):
        return Tensor(values)


def test_tensors_pass(splats):
    tensors = knead.Splats(*(Tensor(a) for a in (splats.means, splats.scales, splats.rotations)))
    moved, expected = knead.deform_mesh(tensors, BEND), knead.deform_mesh(splats, BEND)
    assert isinstance(moved.means, Tensor) and (moved.scales.values == expected.scales).all()


def test_what_moves_centres_alone_says_so(tmp_path, splats):
    splats.write(tmp_path / "capture.ply")
    shape = knead.read(tmp_path / "capture.ply")
    shape.vertices = knead.deform(shape, BEND)
    with pytest.warns(UserWarning, match="deform_mesh"):
        shape.write(tmp_path / "wrong.ply")


def test_what_are_no_splats_is_refused(splats):
    with pytest.raises(knead.InvalidInput, match="scales must have shape"):
        knead.deform_mesh(knead.Splats(splats.means, splats.scales[:5], splats.rotations), BEND)
    with pytest.raises(knead.InvalidInput, match="harmonics must have shape"):
        knead.deform_mesh(knead.Splats(splats.means, splats.scales, splats.rotations, splats.harmonics[:, :5]), BEND)
    with pytest.raises(TypeError, match="real numbers"):
        knead.deform_mesh(knead.Splats(splats.means, splats.scales, splats.rotations.astype(str)), BEND)
    with pytest.raises(knead.InvalidInput, match="holds no splats"):
        knead.Shape(splats.means).splats


def test_long_splats_are_split(splats):
    splats.scales += np.float32(3)
    bent = knead.deform_mesh(splats, BEND, max_splats=5000)
    assert 200 < len(bent) < 5000 and bent.harmonics.shape == (len(bent), 16, 3)
    with pytest.warns(UserWarning, match="at most 210 splats are allowed, too few for the pieces"):
        assert len(knead.deform_mesh(splats, BEND, max_splats=210)) <= 210
    assert len(knead.deform_mesh(splats, BEND, max_splats=0)) == 200
