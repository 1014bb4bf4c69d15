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
    fit = knead.fit((v, faces), (1.2 * target, faces), volume="total", surface=False, landmarks=np.stack([chosen(v)] * 2, axis=1), also=[v[:5]])
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
    refuses("volume", volume="some")
    refuses("above 1", max_stretch=0.5)
    refuses("landmarks 0 and 1", landmarks=[[0, 0], [0, 40]])
    with pytest.raises(knead.InvalidInput, match="without faces"):
        knead.fit(v, target)
    with pytest.raises(TypeError):
        knead.fit(7, target)


def ellipsoid(scale):
    """A ball of 258 vertices, stretched."""
    v = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]
    f = [[0, 2, 4], [0, 4, 3], [0, 3, 5], [0, 5, 2], [1, 4, 2], [1, 3, 4], [1, 5, 3], [1, 2, 5]]
    v = [np.array(p, float) for p in v]
    for _ in range(3):
        middle, faces = {}, []
        for face in f:
            new = []
            for a, b in zip(face, face[1:] + face[:1]):
                key = (min(a, b), max(a, b))
                if key not in middle:
                    middle[key] = len(v)
                    v.append((v[a] + v[b]) / np.linalg.norm(v[a] + v[b]))
                new.append(middle[key])
            a, b, c = face
            faces += [[a, new[0], new[2]], [b, new[1], new[0]], [c, new[2], new[1]], new]
        f = faces
    return np.array(v) * scale, np.array(f)


def volume_of(v, t):
    return np.einsum("ij,ij->", v[t[:, 0]], np.cross(v[t[:, 1]], v[t[:, 2]])) / 6


def test_a_fit_with_free_volume_grows_to_the_targets_volume():
    v, faces = ellipsoid([1, 1, 1.5])
    target, _ = ellipsoid([1.2, 1.1, 1.5])
    difference = volume_of(target, faces) / volume_of(v, faces) - 1
    kept = knead.fit((v, faces), (target, faces))
    free = knead.fit((v, faces), (target, faces), volume="free")
    assert abs(kept.report["volume_error"]) < 1e-3 and kept.report["det_least"] is None
    assert free.report["volume_error"] == pytest.approx(difference, rel=0.1)
    assert 1 < free.report["det_least"] < 1 + difference < free.report["det_greatest"] < 2
    assert free.report["distance_after"]["mean"] < 0.3 * kept.report["distance_after"]["mean"]
    assert free.report["sound"]
    assert (knead.deform(v, free.session, faces) == free.vertices).all()


def test_the_mean_of_ellipsoids_is_one():
    widths = [0.8, 1.0, 1.2]
    shapes = [ellipsoid([w, 1, 1.6]) for w in widths]
    people = knead.mean(shapes, template=1)
    assert [fit.problem for fit in people.fits] == [""] * 3 and people.mean.problem == ""
    v, faces = people.template
    assert np.ptp(people.mean.vertices, axis=0) == pytest.approx([2, 2, 3.2], rel=0.02)
    # One number makes the difference, and the widths are evenly spread.
    assert people.deviations[0] > 4 * people.deviations[1]
    order = people.weights[:, 0] * np.sign(people.weights[-1, 0])
    assert (np.diff(order) > 0.3).all()
    one = people.along([people.weights[2, 0]])
    assert np.ptp(one.vertices, axis=0)[0] == pytest.approx(2.4, rel=0.03)
    assert (knead.deform(v, one.session, faces) == one.vertices).all()
    with pytest.raises(knead.InvalidInput, match="at most"):
        people.along([0] * 9)


def test_a_mean_says_what_it_needs():
    ball = ellipsoid([1, 1, 1])
    with pytest.raises(knead.InvalidInput, match="two or more"):
        knead.mean([ball])
    with pytest.raises(knead.InvalidInput, match="template"):
        knead.mean([ball, ball], template=2)
    with pytest.raises(knead.InvalidInput, match="one entry for each"):
        knead.mean([ball, ball], maps=[None])
    with pytest.raises(knead.InvalidInput, match="total"):
        knead.mean([ball, ball], volume="total")


def test_print_presses_a_picture_in(tmp_path):
    picture = tmp_path / "white.pgm"
    picture.write_bytes(b"P5\n2 1\n255\n\xff\xff")
    v, faces = ellipsoid([1, 1, 1])
    pressed = knead.Print(file=picture, point=[0, 0, 1], height=0.4, depth=0.1, bump=0.1)
    assert knead.deform(v, pressed, faces)[0] == pytest.approx([0, 0, 0.9], abs=0.01)
    assert knead.deform(v, pressed.replace(depth=-0.1), faces)[0] == pytest.approx([0, 0, 1.1], abs=0.01)


def test_inflate_adds_the_volume_that_is_asked_for():
    v, faces = ellipsoid([1, 1, 1])
    grown = knead.deform(v, knead.Inflate(points=[[0, 0, 1]], radius=0.9, volume=0.05), faces)
    assert volume_of(grown, faces) - volume_of(v, faces) == pytest.approx(0.05, rel=1e-3)
    beyond = np.linalg.norm(v - [0, 0, 1], axis=1) > 0.9
    assert (grown[beyond] == v[beyond]).all() and beyond.sum() > 200
    report = knead.certify(v, grown, faces, knead.Inflate(points=[[0, 0, 1]], radius=0.9, volume=0.05))
    assert 0.1 < report["det_least"] < 1.2 < report["det_greatest"] and report["volume_error_sampling"] is None
