"""Sessions with walls: the patches of files and of arrays give the points of the command."""

import copy
import pickle

import numpy as np
import pytest
from conftest import SOURCE, run

import knead

N = 9
WALLS = [{"patch": "outer", "slide": True}, {"patch": "bottom", "slide": True}, {"patch": "top", "hold": True, "width": 0.3}]
TURN = {"tool": "rotate", "center": [0.6, 0.6, 1], "axis": [0.2, 0.1, 1], "angle_deg": "$angle", "inner": 0.2, "outer": 0.9}


def pipe():
    """A quarter of a pipe about the z axis, of the radii 0.25 and 1: points, hexahedra, and faces of patches."""
    z, y, x = (a.ravel() for a in np.meshgrid(*[np.linspace(0, 1, N)] * 3, indexing="ij"))
    radius, angle = 0.25 + 0.75 * x, np.pi / 2 * y
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 2 * z])
    number = np.arange(N**3).reshape(N, N, N)

    def squares(layer):
        return np.stack([layer[:-1, :-1], layer[:-1, 1:], layer[1:, 1:], layer[1:, :-1]], axis=-1).reshape(-1, 4)

    cells = np.concatenate([np.hstack([squares(number[k]), squares(number[k + 1])]) for k in range(N - 1)])
    return points, cells, {"outer": squares(number[:, :, -1]), "bottom": squares(number[0]), "top": squares(number[-1])}


@pytest.fixture
def session():
    return knead.Session(TURN, parameters={"angle": 12}, walls=WALLS)


@pytest.fixture
def file(tmp_path):
    points, cells, patches = pipe()
    lines = ["NDIME= 3", f"NELEM= {len(cells)}", *(f"12 {' '.join(map(str, cell))}" for cell in cells)]
    lines += [f"NPOIN= {len(points)}", *(" ".join(map(repr, map(float, p))) for p in points), f"NMARK= {len(patches)}"]
    for name, faces in patches.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(faces)}", *(f"9 {' '.join(map(str, f))}" for f in faces)]
    path = tmp_path / "pipe.su2"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_files_and_arrays_give_what_the_command_gives(session, file, tmp_path):
    points, cells, patches = pipe()
    shape = knead.read(file)
    moved = knead.deform(shape, session)
    outer = np.unique(patches["outer"])
    assert np.abs(np.hypot(*moved[outer, :2].T) - 1).max() < 1e-12
    assert np.linalg.norm(moved - points, axis=1)[outer].max() > 0.03
    assert (moved[np.unique(patches["bottom"]), 2] == 0).all()
    top = np.unique(patches["top"])
    assert (moved[top] == points[top]).all()
    assert (knead.deform(points, session, patches=patches, cells=cells) == moved).all()
    assert (knead.deform(points, session, patches=shape.patches, threads=1) == moved).all()
    session.write(tmp_path / "turn.knead")
    run("deform", file, tmp_path / "turn.knead", "-q", "--digits", "shortest", "-o", tmp_path / "moved.su2")
    assert (knead.read(tmp_path / "moved.su2").vertices == moved).all()


def test_shapes_name_their_patches(file):
    shape = knead.read(file)
    assert list(shape.patches) == ["outer", "bottom", "top"]
    assert shape.patches["top"].shape == (2 * (N - 1) ** 2, 3)
    for other in (copy.copy(shape), pickle.loads(pickle.dumps(shape))):
        assert (other.patches["outer"] == shape.patches["outer"]).all()
    assert knead.Shape(np.zeros((1, 3))).patches == {}


def test_a_plane_needs_no_faces():
    points, _, patches = pipe()
    walls = [{"patch": "bottom", "slide": True}]
    session = knead.Session({**TURN, "angle_deg": 12, "center": [0.6, 0.6, 0.2]}, walls=walls)
    bottom = np.unique(patches["bottom"])
    moved = knead.deform(points, session, patches={"bottom": bottom})
    assert (moved[bottom, 2] == 0).all() and np.linalg.norm(moved - points, axis=1)[bottom].max() > 0.03


def test_cells_of_two_dimensions_are_judged():
    x, y = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 7), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(49)])
    corner = np.arange(49).reshape(7, 7)
    quads = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 3, 2]]])  # in both directions
    tear = knead.Implicit(path=[[0.5, 0.5, 0], [0.8, 0.58, 0]], inner=0.02, outer=0.05)
    for session, cells in ((knead.Session(tear, walls=[{"patch": "left", "hold": True}]), c) for c in (quads, triangles)):
        with pytest.raises(knead.AccuracyError, match="would be inverted"):
            knead.deform(points, session, patches={"left": np.arange(7)}, cells=cells)
        moved = knead.deform(points, session, patches={"left": np.arange(7)}, cells=cells, until=1.1)  # the mask counts
        assert (moved[:, 2] == 0).all() and np.abs(moved - points).max() > 0.02
    with pytest.raises(knead.InvalidInput, match=r"the shape \(m, 3\) or \(m, 4\)"):
        knead.deform(points, session, patches={"left": np.arange(7)}, cells=[[0, 1, 2, 3, 4]])


def test_sessions_keep_their_walls(session):
    assert session.walls == [{**wall} for wall in WALLS]
    for same in (knead.Session.parse(session.text()), pickle.loads(pickle.dumps(session)), session[:], copy.copy(session),
                 knead.Session(session), eval(repr(knead.Session(walls=WALLS)))):
        assert same.walls == WALLS
    assert session(angle=3).walls == WALLS and session != knead.Session(TURN, parameters={"angle": 12})
    with pytest.raises(knead.InvalidInput, match='needs one of "hold"'):
        knead.Session(walls=[{"patch": "a"}])


def test_what_is_refused(session):
    points, cells, patches = pipe()
    with pytest.raises(knead.InvalidInput, match='no patch "outer"'):
        knead.deform(points, session)
    with pytest.raises(knead.InvalidInput, match='the patch "outer" has the point 729, but there are 729'):
        knead.deform(points, session, patches={"outer": [[1, 2, N**3]]})
    with pytest.raises(knead.InvalidInput, match="must have the shape"):
        knead.deform(points, session, patches={"outer": np.zeros((2, 1), int)})
    with pytest.raises(TypeError, match="whole numbers"):
        knead.deform(points, session, patches={"outer": [0.5]})
    with pytest.raises(knead.InvalidInput, match="leave out faces"):
        knead.deform(points, session, also=[points])
    with pytest.raises(knead.AccuracyError, match="cells would be inverted; deform less"):
        knead.deform(points, session(angle=170), patches=patches, cells=cells)
    for call in (knead.Flow, lambda s: s.resolve(points), lambda s: s.vjp(points, points),
                 lambda s: knead.deform_cells(points, cells, s)):
        with pytest.raises(knead.InvalidInput, match="the session has walls, which only knead.deform takes"):
            call(session)


def test_patches_of_openfoam_lie_in_files_beside(tmp_path):
    path = SOURCE / "tests/support/polyMesh/points"
    shape = knead.read(path)
    held = np.unique(shape.patches["symmetry"])
    assert len(shape.patches) == 4 and (shape.vertices[held, 2] == 0).all()
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    size = np.linalg.norm(high - low)
    pull = knead.Implicit(path=[(low + high) / 2, (low + high) / 2 + [0.02 * size, 0, 0]], inner=0.01 * size, outer=0.6 * size)
    session = knead.Session(pull, walls=[{"patch": "symmetry", "hold": True}])
    moved = knead.deform(shape, session)
    assert (moved[held] == shape.vertices[held]).all() and np.abs(moved - shape.vertices).max() > 0.005 * size
    lost = pickle.loads(pickle.dumps(shape))
    lost._path = str(tmp_path / "points")
    with pytest.raises(knead.FileError, match="the file faces of its mesh is neither beside it"):
        lost.patches
