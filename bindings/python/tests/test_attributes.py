"""Attributes of shapes are read and written; shapes and sessions are drawn in notebooks."""

import struct
import zlib

import numpy as np
import pytest
from conftest import run

import knead


@pytest.fixture
def cube(tmp_path):
    """A cube of triangles with colours and a label for each face, in a file with a comment."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    lines = ["ply", "format ascii 1.0", "comment a cube", "element vertex 8"]
    lines += [f"property float {axis}" for axis in "xyz"] + [f"property uchar {colour}" for colour in ("red", "green", "blue")]
    lines += ["element face 12", "property list uchar int vertex_indices", "property int label", "end_header"]
    lines += [f"{x} {y} {z} {10 * k} 0 255" for k, (x, y, z) in enumerate(corners)] + ["3 %d %d %d %d" % (*face, k) for k, face in enumerate(faces)]
    (tmp_path / "cube.ply").write_text("\n".join(lines) + "\n")
    return tmp_path / "cube.ply"


def test_attributes_are_read(cube):
    shape = knead.read(cube)
    assert list(shape.attributes) == ["color", "label"] and "color" in shape.attributes
    colours = shape.attributes["color"]
    assert colours.dtype == np.uint8 and colours.shape == (8, 3)
    assert (colours[:, 0] == np.arange(8) * 10).all() and (colours[:, 2] == 255).all()
    assert (shape.attributes["label"] == np.arange(12)).all()
    with pytest.raises(KeyError, match="weight"):
        shape.attributes["weight"]


def test_attributes_are_written_beside_all_else(cube, tmp_path):
    shape = knead.read(cube)
    shape.vertices = shape.vertices + [1, 0, 0]
    colours = shape.attributes["color"]
    colours[:, 1] = 7
    shape.attributes["color"] = colours
    shape.write(tmp_path / "out.ply")
    assert "comment a cube" in (tmp_path / "out.ply").read_text()
    again = knead.read(tmp_path / "out.ply")
    assert (again.attributes["color"] == colours).all() and (again.attributes["label"] == np.arange(12)).all()
    assert (again.vertices == shape.vertices).all() and (again.faces == shape.faces).all()


def test_new_attributes_have_a_row_for_each_vertex_or_face(cube, tmp_path):
    shape = knead.read(cube)
    shape.attributes["pressure"] = np.linspace(0, 1, 8)
    shape.attributes["part"] = np.arange(12, dtype=np.uint8)
    shape.write(tmp_path / "out.ply")
    again = knead.read(tmp_path / "out.ply")
    assert (again.attributes["pressure"] == np.linspace(0, 1, 8)).all()
    assert again.attributes["part"].dtype == np.uint8 and (again.attributes["part"] == np.arange(12)).all()


@pytest.mark.parametrize(
    "name, values, error, word",
    [
        ("color", np.zeros((7, 3), np.uint8), knead.InvalidInput, "must have shape"),
        ("color", np.full((8, 3), 300), knead.InvalidInput, "uint8"),
        ("color", np.full((8, 3), 0.5), knead.InvalidInput, "uint8"),
        ("color", np.full((8, 3), "red"), TypeError, "real numbers"),
        ("mass", np.zeros(5), knead.InvalidInput, "must have shape"),
    ],
)
def test_what_does_not_fit_is_refused(cube, name, values, error, word):
    shape = knead.read(cube)
    before = shape.attributes["color"]
    with pytest.raises(error, match=word):
        shape.attributes[name] = values
    assert (shape.attributes["color"] == before).all()


def test_a_cloud_gets_colours(tmp_path):
    cloud = knead.Shape(np.eye(3))
    cloud.attributes["color"] = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255]], np.uint8)
    cloud.write(tmp_path / "cloud.ply")
    assert (knead.read(tmp_path / "cloud.ply").attributes["color"] == np.eye(3) * 255).all()


def pixels_of(png):
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data = 8, b""
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        kind, content = png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + content) == struct.unpack(">I", png[at + 8 + length : at + 12 + length])[0]
        if kind == b"IHDR":
            width, height = struct.unpack(">2I", content[:8])
        if kind == b"IDAT":
            data += content
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + 3 * width)
    return rows[:, 1:].reshape(height, width, 3)


def test_notebooks_draw_shapes_and_sessions(tmp_path):
    run("make", "sphere", "-n", 1000, "-q", "-o", tmp_path / "ball.ply")
    shape = knead.read(tmp_path / "ball.ply")
    session = knead.Session(knead.Implicit(path=[[0, 0, 1], [0, 0, 1.3]], inner=0.1, outer=0.5), mesh="ball.ply")
    session.write(tmp_path / "s.knead")
    assert session._repr_png_() is None  # of no file
    png = shape._repr_png_()
    if png is None:
        pytest.skip("no OpenGL")
    picture = pixels_of(png)
    assert picture.std() > 5
    assert (picture == knead.render(shape, size=(480, 360))).all()
    drawn = pixels_of(knead.Session.read(tmp_path / "s.knead")._repr_png_())
    assert (drawn != picture).any()
