"""Anything in the place of arrays, sessions and numbers: the interpreter survives, and only errors that are promised come
out. KNEAD_FUZZ_MINUTES: how long to go on with new values; without it the same few are taken in every run."""

import faulthandler
import os
import signal
import time

import numpy as np
import pytest

import knead

hypothesis = pytest.importorskip("hypothesis")
from hypothesis import strategies as st  # noqa: E402
from hypothesis.extra import numpy as hnp  # noqa: E402

MINUTES = float(os.environ.get("KNEAD_FUZZ_MINUTES", 0))
PROMISED = (TypeError, ValueError, OSError, knead.AccuracyError, knead.Unavailable)
SECONDS = 10  # a call that takes longer is interrupted, as by Ctrl-C
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


class Odd:
    """An object whose attributes are given, and which answers numpy with what is given, or raises it."""

    def __init__(self, array, **attributes):
        self.array = array
        self.__dict__.update(attributes)

    def __array__(self, *_, **__):
        if isinstance(self.array, Exception):
            raise self.array
        return self.array

    def __len__(self):
        return 3


numbers = st.one_of(
    st.floats(-2, 2),
    st.floats(),
    st.integers(-3, 9),
    st.sampled_from([2**31, 2**32, 2**63, 2**64, 10**400, -1, True, np.float32(0.5), np.int8(3), np.nan]),
)
dtypes = st.one_of(
    hnp.floating_dtypes(endianness="?"),
    hnp.integer_dtypes(endianness="?"),
    hnp.unsigned_integer_dtypes(),
    hnp.boolean_dtypes(),
    hnp.complex_number_dtypes(),
    hnp.unicode_string_dtypes(),
    st.just(np.dtype("datetime64[s]")),
    st.just(np.dtype([("x", "f8"), ("y", "i4")])),
)
shapes = st.one_of(st.tuples(st.integers(0, 6), st.just(3)), hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))


def laid_out(array, layout):
    """Returns the values of an array in another order of memory."""
    if layout == 1:
        return np.asfortranarray(array)
    if layout == 2 and array.ndim:
        return np.repeat(array, 2, axis=0)[::2]
    if layout == 3 and array.ndim:
        return np.ascontiguousarray(array[::-1])[::-1]
    if layout == 4:
        array.flags.writeable = False
    if layout == 5 and array.size:
        return np.broadcast_to(array.flat[0], array.shape)
    return array


arrays = st.builds(laid_out, dtypes.flatmap(lambda d: hnp.arrays(d, shapes)), st.integers(0, 5))
lists = st.recursive(numbers, lambda inner: st.lists(inner, max_size=4), max_leaves=12)
texts = st.sampled_from(["", "a\0b", "\ud800", "é", "float64", "rk4", "auto", "ball", "/", "no.such.ply", "x" * 300])
plain = st.one_of(arrays, lists, numbers, texts, st.none(), st.binary(max_size=8), st.just(object()), st.just({"a": 1}))
objects = st.builds(
    Odd,
    st.one_of(plain, st.sampled_from([ValueError("odd"), TypeError("odd")])),
    vertices=plain,
    faces=plain,
) | st.builds(Odd, plain, points=plain, cells=plain)
anything = st.one_of(plain, objects)

points = st.one_of(
    st.integers(0, 6).flatmap(lambda n: hnp.arrays(np.float64, (n, 3), elements=st.floats(-2, 2))),
    hnp.arrays(np.float64, (4, 3)),
    st.just(TETRAHEDRON[0]),
)
vertices = st.one_of(points, points, anything)
faces = st.one_of(
    st.just(TETRAHEDRON[1]),
    hnp.arrays(np.int64, (3, 3), elements=st.integers(0, 3)),
    st.lists(st.lists(st.integers(-1, 5), max_size=5), max_size=4),
    st.none(),
    anything,
)
vector = st.one_of(st.lists(st.floats(-2, 2), min_size=3, max_size=3), st.just([0, 1, 0]))
path = st.lists(vector, min_size=2, max_size=3)
positive = st.floats(0.05, 2)
good_strokes = st.one_of(
    st.builds(lambda p, a, b: knead.Implicit(path=p, inner=a, outer=a + b), path, positive, positive),
    st.builds(lambda p, a, d: knead.Paint(path=p, outer=a, depth=d), path, positive, st.floats(-0.2, 0.2)),
    st.builds(lambda n, a: knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[1, 0, 0], width=n, angle_deg=a),
              positive, st.floats(-90, 90)),
    st.builds(lambda i, a: knead.Twist(center=[0, 0, 0], axis=[0, 1, 0], rate_deg=a, inner=-i, outer=i),
              positive, st.floats(-90, 90)),
    st.builds(lambda p: knead.Relax(points=[p], radius=0.5), vector),
)  # fmt: skip
TOOLS = [getattr(knead, name) for name in knead.__all__ if isinstance(getattr(knead, name), type)]
TOOLS = [tool for tool in TOOLS if issubclass(tool, knead.Stroke) and tool is not knead.Stroke]
KEYS = sorted({key for tool in TOOLS for key in tool.__signature__.parameters})
sessions = st.one_of(good_strokes, st.lists(good_strokes, max_size=3), good_strokes, anything)
accuracy = {
    "relative_tolerance": st.one_of(st.just(1e-4), anything),
    "precision": st.one_of(st.sampled_from(["float32", "float64"]), anything),
    "integrator": st.one_of(st.sampled_from(["tsit5", "rk4"]), anything),
    "threads": st.one_of(st.integers(0, 2), anything),
}
more = {
    "inverse": anything,
    "until": st.one_of(st.floats(0, 3), anything),
    "diagonal": st.one_of(positive, anything),
    "out": anything,
    "progress": st.sampled_from([lambda f: True, lambda f: False, lambda: 0, 5]),
}
settings = {
    "max_edge": st.one_of(positive, anything),
    "max_angle_deg": st.one_of(st.floats(1, 180), anything),
    "max_chord": st.one_of(st.floats(0.001, 1), anything),
    "min_edge": st.one_of(positive, anything),
    "iterations": st.one_of(st.integers(0, 3), anything),
}
looks = {
    "size": st.one_of(st.just((16, 16)), anything),
    "view": anything,
    "up": anything,
    "perspective": st.one_of(st.integers(0, 90), anything),
    "background": anything,
    "material": anything,
    "ground": anything,
    "session": sessions,
}


fits = {
    "volume": st.one_of(st.sampled_from(["keep", "total", "free"]), anything),
    "align": st.one_of(st.booleans(), anything),
    "surface": st.one_of(st.booleans(), anything),
    "also": anything,
    "max_stretch": st.one_of(numbers, anything),
    "threads": st.one_of(st.integers(0, 2), anything),
}


def some(keys):
    """Keyword arguments: none, or one or two of these."""
    return st.lists(st.sampled_from(sorted(keys)), max_size=2).flatmap(
        lambda names: st.fixed_dictionaries({name: keys[name] for name in names})
    )


def use_flow(draw):
    flow = knead.Flow(draw(sessions))
    name = draw(st.sampled_from(["move", "part", "path", "velocity", "jacobian", "add"]))
    if name == "part":
        flow = flow.part(draw(numbers), draw(anything))
        name = "move"
    if name == "add":
        flow + draw(st.one_of(anything, st.just(flow)))
    elif name == "path":
        flow.path(draw(vertices), draw(st.one_of(st.integers(0, 9), arrays, texts, st.floats())), **draw(some(accuracy)))
    elif name == "velocity":
        flow.inverse().velocity(draw(vertices), draw(anything))
    elif name == "jacobian":
        flow.jacobian(draw(vertices), **draw(some(accuracy)))
    else:
        flow(draw(vertices), **draw(some(accuracy)))


def use_workbench(draw):
    bench = knead.Workbench(draw(vertices), draw(faces))
    views = [bench.vertices]
    for name in draw(st.lists(st.sampled_from(["set_live", "finish", "undo", "redo", "vertices", "session"]), max_size=8)):
        if name == "set_live":
            bench.set_live(draw(sessions))
        elif name in ("vertices", "session"):
            views.append(getattr(bench, name))
        else:
            getattr(bench, name)()
    del bench
    for view in views:
        np.sum(view) if isinstance(view, np.ndarray) else len(view)


directions = st.one_of(vector, vector, anything)


def use_surface(draw):
    surface = knead.Surface(draw(vertices), draw(faces))
    name = draw(st.sampled_from(["move", "hit", "middle", "thickness", "ring", "part", "with_safe_zone"]))
    if name == "move":
        surface.move(draw(vertices))
    elif name == "ring":
        surface.ring(draw(directions), draw(directions), draw(numbers), draw(numbers))
    elif name == "part":
        surface.part(draw(directions), draw(directions), axis=draw(directions), angle_deg=draw(numbers))
    elif name == "with_safe_zone":
        surface.with_safe_zone(draw(good_strokes))
    else:
        getattr(surface, name)(draw(directions), draw(directions))


def use_paint_drag(draw):
    falloff = draw(st.one_of(st.integers(2, 8), numbers))
    drag = knead.PaintDrag(outer=draw(st.one_of(positive, numbers)), depth=draw(numbers), falloff=falloff)
    for _ in range(draw(st.integers(0, 3))):
        outer, pressure = draw(st.none() | numbers), draw(st.one_of(st.floats(0.1, 1), numbers))
        drag.touch(draw(directions), draw(directions), outer=outer, pressure=pressure)
    drag.finish()
    assert drag.spacing > 0 and all(stroke.tool == "paint" for stroke in drag.strokes)


def use_brush(draw):
    name = draw(st.one_of(st.sampled_from(["move", "snakehook", "paint", "crease", "pinch", "flatten", "clay"]), anything))
    made = knead.brush(name, draw(st.lists(directions, max_size=3)), radius=draw(numbers), amount=draw(st.none() | numbers))
    assert made.tool in ("implicit", "paint")


def use_symmetric(draw):
    planes = draw(st.one_of(st.sampled_from(["", "x", "xz", "xyz", "w"]), anything))
    strokes = knead.symmetric(draw(sessions), planes, size=draw(numbers), image_file=draw(anything))
    assert all(isinstance(stroke, knead.Stroke) for stroke in strokes)


def use_fit(draw):
    shapes = st.one_of(st.tuples(vertices, faces), st.just(TETRAHEDRON), anything)
    pairs = st.one_of(st.none(), st.tuples(vertices, vertices), anything)
    fit = knead.fit(draw(shapes), draw(shapes), draw(pairs), draw(pairs), **draw(some(fits)))
    assert isinstance(fit.session, knead.Session) and isinstance(fit.report, dict)


def use_mean(draw):
    shapes = st.one_of(st.lists(st.one_of(st.tuples(vertices, faces), st.just(TETRAHEDRON)), max_size=3), anything)
    keys = {**{key: fits[key] for key in ("volume", "align", "max_stretch", "threads")}, "template": anything, "maps": anything}
    people = knead.mean(draw(shapes), **draw(some(keys)))
    assert isinstance(people, knead.Population) and isinstance(people.along(draw(arrays)), knead.Fit)


RIG = np.tile(np.eye(4), (2, 1, 1))


def use_skin(draw):
    rows = st.one_of(st.just(np.eye(4, 2)), vertices, anything)
    matrices = st.one_of(st.just(RIG), anything)
    parents = draw(st.one_of(st.none(), st.just([-1, 0]), anything))
    posed = knead.skin(*TETRAHEDRON, draw(rows), draw(matrices), draw(matrices), parents=parents, detail=draw(numbers))
    assert all(isinstance(p, knead.Posed) for p in (posed if isinstance(posed, list) else [posed]))


def use_correctives(draw):
    rows = st.one_of(st.just(np.eye(4, 2)), vertices, anything)
    matrices = st.one_of(st.just(RIG), anything)
    made = knead.correctives(*TETRAHEDRON, draw(rows), draw(matrices), draw(matrices), rigid_weight=draw(numbers))
    assert all(isinstance(c, knead.Corrective) for c in made)


def use_session(draw):
    session = knead.Session(draw(sessions), mesh=draw(st.none() | texts), note=draw(st.none() | anything))
    name = draw(st.sampled_from(["resolve", "append", "item", "text"]))
    if name == "resolve":
        session.resolve(draw(vertices), draw(faces))
    elif name == "append":
        session.append(draw(anything))
    elif name == "item":
        session[draw(st.integers(0, 0)) if len(session) else slice(0, 9)] = draw(anything)
    else:
        repr(session), session == knead.Session(session)


def use_walls(draw):
    wall = st.sampled_from([{"hold": True}, {"slide": True}, {"layers": True}, {"periodic": "b"}, {"width": 1, "hold": True}])
    walls = draw(st.lists(wall.map(lambda keys: {"patch": "a", **keys}), max_size=2) | anything)
    session = knead.Session(draw(good_strokes), walls=walls)
    repr(session), session.walls
    patches = st.dictionaries(st.sampled_from(["a", "b"]), st.one_of(faces, anything), max_size=2)
    keys = {"patches": st.one_of(patches, anything), "cells": st.one_of(faces, anything), **accuracy, **more}
    knead.deform(draw(vertices), session, **draw(some(keys)))


def use_parameters(draw):
    turn = {"tool": "rotate", "center": [0, 0, 0], "axis": [0, 0, 1], "angle_deg": "$angle", "inner": 0.1, "outer": "$b"}
    session = knead.Session(turn, parameters={"angle": draw(numbers), draw(st.sampled_from(["b", "c"])): draw(anything)})
    session = session(**{draw(st.sampled_from(["angle", "b", "c"])): draw(anything)})
    assert knead.Session.parse(session.text()) == session and session.bounds.keys() == session.parameters.keys()
    if draw(st.booleans()):
        session.jvp(draw(vertices), draw(anything), relative_tolerance=draw(numbers), diagonal=draw(st.none() | numbers))
    else:
        session.vjp(draw(vertices), draw(vertices), threads=draw(numbers))


def use_tool(draw):
    tool = draw(st.sampled_from(TOOLS))
    keys = {key: draw(anything) for key in tool.__signature__.parameters if draw(st.booleans())}
    stroke = tool(**keys)
    assert eval(repr(stroke)) == stroke


def use_stroke(draw):
    keys = draw(st.dictionaries(st.sampled_from(["tool", *KEYS]), anything, max_size=4))
    good = draw(good_strokes)
    if draw(st.booleans()):
        good.replace(**{key: value for key, value in keys.items() if key != "tool"})
    knead.stroke({**good.to_dict(), **keys} if draw(st.booleans()) else draw(anything))


def use_files(draw, folder):
    kind = draw(st.sampled_from(["ply", "obj", "stl", "off", "gltf", "glb", "xyz", "pcd", "knead"]))
    start = {"ply": b"ply\nformat ascii 1.0\n", "off": b"OFF\n", "obj": b"v 0 0 0\n", "knead": b'{"knead": 1}\n'}
    file = folder / f"fuzz.{kind}"
    file.write_bytes(draw(st.sampled_from([b"", start.get(kind, b"")])) + draw(st.binary(max_size=60)))
    read = knead.Session.read if kind == "knead" else knead.read
    read(draw(st.one_of(st.just(file), anything)))


def use_shape(draw, folder):
    file = folder / "shape.off"
    file.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 3 2\n")
    shape = knead.read(file)
    keys = draw(some({"double": anything, "decimals": anything}))
    shape.write(folder / draw(st.sampled_from(["a.ply", "a.obj", "a.off", "a.nothing"])), **keys)
    assert shape.patches == {}
    shape.vertices = draw(vertices)
    shape.write(folder / "b.ply")


def use_remesh(draw):
    keys = draw(some({**settings, **accuracy}))
    # the least of the sizes that may be asked for, so that a mesh of four faces stays small
    knead.remesh(draw(vertices), draw(faces), draw(st.none() | sessions), max_vertices=2000, **keys)


moments = st.integers(-1, 5)
films = {"ease": st.sampled_from(["linear", "smooth", "", 3]), "hold": st.one_of(st.integers(-1, 2), numbers), **accuracy}


def use_animate(draw, folder):
    name = draw(st.sampled_from(["a.pc2", "a.mdd", "a.glb", "a.usda", "a.pvd", "a.ply", ""]))
    knead.animate(folder / name, draw(vertices), draw(sessions), draw(moments), draw(faces), **draw(some(films)))


def use_write(draw, folder):
    path = folder / draw(st.sampled_from(["a.ply", "a.obj", "a.xyz", "a.x"]))
    knead.write(path, draw(vertices), draw(faces), double=draw(anything))


def use_write_frames(draw, folder):
    frames = st.one_of(st.lists(vertices, max_size=3), anything)
    knead.write_frames(folder / draw(st.sampled_from(["a.pc2", "a.glb", "a.usda", "a.x"])), draw(frames), draw(faces), fps=draw(numbers))


def use_lattice(draw):
    counts = draw(st.tuples(*[st.integers(0, 4)] * 3))
    displacements = np.full((*counts, 3), draw(numbers), dtype=object)
    keys = draw(some({"mode": st.sampled_from(["volume", "rigid", "spline", "x"]), "degree": st.integers(-1, 16), "axes": anything}))
    box = knead.Lattice(origin=[-1, -1, -1], lengths=draw(st.sampled_from([[2, 2, 2], [1, 0, 1]])), displacements=displacements, **keys)
    assert knead.lattice_points(box).shape == (*counts, 3)
    flow = knead.Flow(box)
    flow.jvp(draw(vertices), draw(st.one_of(st.lists(anything, max_size=2), st.just([displacements]), anything)), **draw(some(accuracy)))
    flow.vjp(draw(vertices), draw(vertices))


MEASURES = ["volume_of", "area_of", "thickness_at", "curvature", "patch_distance"]


def measured(name):
    def use(draw):
        at = [] if name in ("volume_of", "area_of") else [draw(st.one_of(st.lists(st.integers(-1, 9), max_size=3), anything))]
        measure = getattr(knead, name)(draw(vertices), *at, draw(faces))
        measure.jvp(draw(vertices))
        measure.vjp(draw(st.one_of(numbers, anything)))

    return use


USES = {
    "Splats": lambda draw: knead.deform_mesh(
        knead.Splats(draw(vertices), draw(vertices), draw(st.one_of(vertices, anything)), draw(st.one_of(st.none(), vertices))),
        draw(sessions),
    ),
    **{name: measured(name) for name in MEASURES},
    "animate": use_animate,
    "certify": lambda draw: knead.certify(draw(vertices), draw(vertices), draw(faces), draw(sessions), **draw(some(accuracy))),
    "correctives": use_correctives,
    "skin": use_skin,
    "check": lambda draw: knead.check(draw(vertices), draw(faces)),
    "check_cells": lambda draw: knead.check_cells(draw(vertices), draw(st.one_of(faces, anything)), draw(st.one_of(st.none(), vertices))),
    "crossings": lambda draw: knead.crossings(draw(vertices), draw(faces)),
    "deform": lambda draw: knead.deform(draw(vertices), draw(sessions), draw(faces), **draw(some({**accuracy, **more}))),
    "deform_cells": lambda draw: knead.deform_cells(draw(vertices), draw(st.one_of(faces, anything)), draw(sessions), **draw(some(accuracy))),
    "deform_mesh": lambda draw: knead.deform_mesh(draw(anything), draw(sessions), **draw(some(accuracy))),
    "files": use_files,
    "fit": use_fit,
    "flow": use_flow,
    "mean": use_mean,
    "lattice_points": use_lattice,
    "PaintDrag": use_paint_drag,
    "brush": use_brush,
    "Surface": use_surface,
    "symmetric": use_symmetric,
    "from_build123d": lambda draw: knead.from_build123d(draw(anything), draw(st.one_of(st.none(), st.floats()))),
    "frames": lambda draw: knead.frames(draw(vertices), draw(sessions), draw(moments), draw(faces), **draw(some(films))),
    "remesh": use_remesh,
    "render": lambda draw: knead.render(draw(vertices), draw(faces), **draw(some(looks))),
    "safe_until": lambda draw: knead.safe_until(draw(vertices), draw(st.one_of(faces, anything)), draw(sessions), **draw(some(accuracy))),
    "parameters": use_parameters,
    "session": use_session,
    "shape": use_shape,
    "stroke": use_stroke,
    "walls": use_walls,
    "widest_outer": lambda draw: knead.widest_outer(draw(vertices), draw(st.one_of(faces, anything)), draw(sessions)),
    "tool": use_tool,
    "write": use_write,
    "write_frames": use_write_frames,
    "workbench": use_workbench,
}


def test_every_public_name_is_tried():
    classes = {tool.__name__ for tool in TOOLS}
    others = {"read": "files", "Shape": "shape", "Session": "session", "Stroke": "tool", "Fit": "fit", "Flow": "flow",
              "Population": "mean", "Posed": "skin", "Corrective": "correctives",
              "Remeshed": "remesh", "Workbench": "workbench", "Measure": "volume_of"}  # fmt: skip
    errors = {"AccuracyError", "FileError", "InvalidInput", "Unavailable"}
    for name in knead.__all__:
        assert name in classes or name in errors or others.get(name, name) in USES, name


class Interrupted(BaseException):
    pass


def interrupt(*_):
    raise Interrupted


def try_once(use, draw, *folder):
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        use(draw, *folder)
    except Interrupted:
        pass
    except PROMISED:
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("name", sorted(USES))
def test_fuzz(name, tmp_path):
    use = USES[name]
    folder = (tmp_path,) if use.__code__.co_argcount == 2 else ()

    @hypothesis.settings(
        max_examples=80 if not MINUTES else 1000,
        deadline=None,
        database=None,
        derandomize=not MINUTES,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(st.data())
    def fuzz(data):
        try_once(use, data.draw, *folder)

    end = time.monotonic() + 60 * MINUTES / len(USES)
    faulthandler.dump_traceback_later(300 + 60 * MINUTES, exit=True)  # where a call does not end and cannot be interrupted
    try:
        fuzz()
        while time.monotonic() < end:
            fuzz()
    finally:
        faulthandler.cancel_dump_traceback_later()
