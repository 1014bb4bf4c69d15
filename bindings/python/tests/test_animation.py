"""Frames of a session, as arrays and as files."""

import numpy as np
import pytest
from conftest import bits, run

import knead


@pytest.fixture
def session(pull):
    return knead.Session([pull, knead.Bend(center=[0, 0, 0], axis=[0, 0, 1], normal=[0, 1, 0], width=1.5, angle_deg=30,
                                           duration=2)])  # fmt: skip


def test_frames_are_what_until_gives(sphere, session):
    frames = knead.frames(sphere.vertices, session, 4)
    assert frames.shape == (4, len(sphere.vertices), 3)
    for frame, strokes in zip(frames, (0, 1, 1.5, 2)):
        assert bits(frame) == bits(knead.deform(sphere.vertices, session, until=strokes))


def test_hold_and_ease(sphere, session):
    held = knead.frames(sphere, session, 3, hold=2, ease="smooth")
    assert len(held) == 7 and bits(held[0]) == bits(held[2]) and bits(held[4]) == bits(held[6])
    for wrong in ({"ease": "slow"}, {"hold": -1}, {"n": 0}):
        with pytest.raises(knead.InvalidInput):
            knead.frames(sphere.vertices, session, **{"n": 3, **wrong})


@pytest.mark.parametrize("name", ["a.pc2", "a.mdd", "a.glb", "a.usda", "a.pvd"])
def test_files_are_those_of_the_command(files, sphere, session, name, tmp_path):
    session.write(tmp_path / "s.knead")
    assert knead.animate(tmp_path / name, sphere.vertices, session, 3, sphere.faces, fps=30)
    ours = (tmp_path / name).read_bytes()
    run("deform", files / "sphere.ply", tmp_path / "s.knead", "--frames", 3, "--fps", 30, "-q", "-o", tmp_path / name)
    assert ours == (tmp_path / name).read_bytes()


def test_frames_of_ones_own(sphere, session, tmp_path):
    frames = knead.frames(sphere, session, 3)
    knead.write_frames(tmp_path / "ours.glb", frames, sphere.faces)
    assert knead.animate(tmp_path / "theirs.glb", sphere, session, 3)
    assert (tmp_path / "ours.glb").read_bytes() == (tmp_path / "theirs.glb").read_bytes()
    for wrong in ([], [frames[0], frames[0][1:]]):
        with pytest.raises(knead.InvalidInput, match="frames"):
            knead.write_frames(tmp_path / "a.pc2", wrong)


def test_nothing_is_written_where_progress_says_no(sphere, session, tmp_path):
    assert not knead.animate(tmp_path / "a.pc2", sphere, session, 3, progress=lambda _: False)
    with pytest.raises(knead.InvalidInput, match="pc2"):
        knead.animate(tmp_path / "a.png", sphere, session, 3)
    assert not list(tmp_path.iterdir())


def test_crossings_are_the_faces_that_check_counts(sphere):
    crossed = sphere.vertices.copy()
    crossed[np.argmax(crossed[:, 2])] -= [0, 0, 3]
    pairs = knead.crossings(crossed, sphere.faces)
    assert pairs.dtype == np.uint32 and len(pairs) == knead.check(crossed, sphere.faces)["self_intersections"] > 0
    assert len(knead.crossings(sphere.vertices, sphere.faces)) == 0
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, -1], [0.6, 0.5, 1], [0.4, 0.6, 1]]
    assert knead.crossings(square, [[0, 1, 2, 3], [4, 5, 6]]).tolist() == [[0, 1]] * 2  # both triangles of the square


def test_a_session_as_text(session, tmp_path):
    again = knead.Session.parse(session.text(), tmp_path / "s.knead")
    assert list(again) == list(session) and again[1].duration == 2
    with pytest.raises(knead.InvalidInput, match="^name:2: "):
        knead.Session.parse('{"knead": 1}\n{"tool": "none"}\n', "name")
