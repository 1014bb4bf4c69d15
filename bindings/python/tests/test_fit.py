"""knead.fit: poses that are known are found again."""

import numpy as np
import pytest

import knead


@pytest.fixture(scope="module")
def rod():
    """A cylinder about z, and how it is bent."""
    turns, rings = 16, 40
    angle = 2 * np.pi * np.arange(turns) / turns
    z = np.linspace(-3, 3, rings)
    side = np.stack([np.tile(0.5 * np.cos(angle), rings), np.tile(0.5 * np.sin(angle), rings), np.repeat(z, turns)], axis=1)
    v = np.concatenate([side, [[0, 0, -3], [0, 0, 3]]])
    i = np.arange((rings - 1) * turns)
    after = i - i % turns + (i + 1) % turns
    k, next_k = np.arange(turns), (np.arange(turns) + 1) % turns
    top = (rings - 1) * turns
    bottom_end, top_end = np.full(turns, len(side)), np.full(turns, len(side) + 1)
    faces = np.concatenate(
        [
            np.stack([i, after, after + turns], axis=1),
            np.stack([i, after + turns, i + turns], axis=1),
            np.stack([next_k, k, bottom_end], axis=1),
            np.stack([top + k, top + next_k, top_end], axis=1),
        ]
    )
    bend = knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[0, 0, -1], angle_deg=30, width=3)
    return v, faces, knead.deform(v, bend)


def chosen(v):
    return np.arange(5, len(v), len(v) // 8)


def test_a_fit_meets_its_landmarks_and_the_surface(rod):
    v, faces, target = rod
    pairs = np.stack([chosen(v)] * 2, axis=1)
    fit = knead.fit((v, faces), (target, faces), landmarks=pairs)
    size = np.linalg.norm(np.ptp(v, axis=0))
    assert np.abs(fit.vertices - target)[chosen(v)].max() < 3e-5 * size
    assert fit.report["distance_after"]["mean"] < 2e-3 < fit.report["distance_before"]["mean"]
    assert fit.report["sound"] and fit.problem == ""
    assert fit.report["crossings_new"] == 0
    # The session does what the fit did, for other points, too.
    assert (knead.deform(v, fit.session) == fit.vertices).all()
    places = np.concatenate([v[pairs[:, 0]], target[pairs[:, 1]], np.zeros((len(pairs), 1))], axis=1)
    again = knead.fit((v, faces), (target, faces), places, also=[v[:10]], threads=1)
    assert (again.vertices == fit.vertices).all()
    assert (again.also[0] == fit.vertices[:10]).all()
    assert again.session == fit.session


def test_a_scaled_fit_is_for_the_scaled_source(rod):
    v, faces, target = rod
    fit = knead.fit((v, faces), (1.2 * target, faces), volume="total", also=[v[:5]])
    assert fit.report["scale"] == pytest.approx(1.2, rel=1e-3)
    assert (fit.also[0] == fit.vertices[:5]).all()


def test_work_can_be_stopped(rod):
    v, faces, target = rod
    assert knead.fit((v, faces), (target, faces), progress=lambda done: False) is None


def test_what_is_wrong_is_said(rod):
    v, faces, target = rod

    def refuses(words, **given):
        with pytest.raises(knead.InvalidInput, match=words):
            knead.fit((v, faces), (target, faces), **given)

    refuses("must be", landmarks=np.zeros((3, 4)))
    refuses("vertices of the source", landmarks=[[len(v), 0]])
    refuses("vertices of the target", landmarks=[[0, -1]])
    refuses("not finite", map=[[0, 0, 0, 0, np.nan, 0]])
    refuses("align", align="perhaps")
    refuses("volume", volume="free")
    refuses("above 1", max_stretch=0.5)
    refuses("landmarks 0 and 1", landmarks=[[0, 0], [0, 40]])
    with pytest.raises(knead.InvalidInput, match="without faces"):
        knead.fit(v, target)
    with pytest.raises(TypeError):
        knead.fit(7, target)
