"""What spec/python.md promises, line by line."""

import json
import re
import threading

import numpy as np
import pytest
from conftest import SOURCE, bits, run

import knead


def test_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+", knead.__version__)
    assert knead.__version__ in (SOURCE / "CMakeLists.txt").read_text()


def test_the_first_example(files, sphere, session):
    shape = knead.read(files / "sphere.ply")
    before = shape.vertices.copy()
    moved = knead.deform(shape.vertices, session)
    assert isinstance(moved, np.ndarray) and moved.dtype == np.float64
    assert bits(shape.vertices) == bits(before)
    shape.vertices = moved
    shape.write(files / "out.ply")
    session.write(files / "s.knead")
    run("deform", files / "sphere.ply", files / "s.knead", "-o", files / "command.ply", "-q")
    assert (files / "out.ply").read_bytes() == (files / "command.ply").read_bytes()


def test_shape(files, sphere):
    assert sphere.vertices.shape[1] == 3 and sphere.vertices.dtype == np.float64
    assert sphere.faces.dtype == np.uint32 and sphere.faces.shape[1] == 3
    assert np.array_equal(sphere.triangles, sphere.faces)
    assert isinstance(sphere.attributes, list)
    with pytest.raises(knead.InvalidInput, match="shape"):
        sphere.vertices = sphere.vertices[1:]


def test_a_shape_written_unchanged_keeps_its_bytes(files, sphere):
    knead.read(files / "sphere.ply").write(files / "again.ply")
    assert (files / "again.ply").read_bytes() == (files / "sphere.ply").read_bytes()


def test_polygons(files):
    (files / "quad.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n")
    shape = knead.read(files / "quad.obj")
    assert [list(f) for f in shape.faces] == [[0, 1, 2, 3], [1, 4, 2]]
    assert shape.triangles.shape == (3, 3)


NAMES = "Implicit Paint Points Handles Stamp Rotate Stretch Twist Bend".split()


def test_strokes_are_classes():
    for name in NAMES:
        cls = getattr(knead, name)
        assert issubclass(cls, knead.Stroke) and cls.__doc__ and cls.__module__ == "knead"


def examples():
    for path in sorted((SOURCE / "examples").rglob("*.knead")):
        yield pytest.param(path, id=str(path.relative_to(SOURCE / "examples")))


@pytest.mark.parametrize("path", examples())
def test_strokes_of_the_examples(path):
    session = knead.Session.read(path)
    assert len(session) > 0
    for stroke in session:
        assert eval(repr(stroke), {"knead": knead}) == stroke
        assert knead.stroke(stroke.to_dict()) == stroke
        assert knead.stroke(json.loads(json.dumps(stroke.to_dict()))) == stroke


def test_strokes_describe_their_keys():
    keys = {key["name"]: key for key in knead.Rotate.describe()}
    assert keys["angle_deg"]["type"] == "float" and keys["angle_deg"]["required"]
    assert keys["axis"]["type"] == "Vector" and not keys["falloff"]["required"] and "strength" in keys


def test_strokes_are_values(pull):
    same = knead.Implicit(path=np.array([[0, 1, 0], [0, 1.4, 0]]), inner=0.1, outer=0.5)
    assert pull == same and hash(pull) == hash(same)
    assert pull != knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.6)
    assert pull.to_dict() == {"tool": "implicit", "path": [[0, 1, 0], [0, 1.4, 0]], "inner": 0.1, "outer": 0.5}
    assert pull.inner == 0.1 and pull.region == "ball" and pull.name == ""
    assert pull.replace(outer=0.6).outer == 0.6
    with pytest.raises(AttributeError):
        pull.inner = 3
    with pytest.raises(AttributeError):
        pull.nothing


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: knead.Implicit(path=[[0, 1, 0], [0, 2, 0]], inner=0.5, outer=0.1), "inner"),
        (lambda: knead.Implicit(path=[[0, 1, 0], [0, 2, 0]], outer=0.1), "inner"),
        (lambda: knead.Implicit(path=[[0, 1, 0], [0, float("nan"), 0]], inner=0.1, outer=0.5), "path"),
        (lambda: knead.Rotate(center=[0, 0, 0], axis=[0, 0, 0], angle_deg=1, inner=0.1, outer=1), "axis"),
        (lambda: knead.Bend(colour="red"), "colour"),
        (lambda: knead.stroke({"tool": "hammer"}), "hammer"),
        (lambda: knead.stroke({}), "tool"),
    ],
)
def test_strokes_are_checked_when_they_are_made(make, words):
    with pytest.raises(knead.InvalidInput, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_session_is_a_list(pull, session, files):
    assert len(session) == 2 and session[0] == pull and list(session)[0] == pull
    part = session[:1]
    assert isinstance(part, knead.Session) and len(part) == 1
    part.append(pull)
    part.extend([pull.to_dict()])
    assert part == knead.Session([pull, pull, pull])
    part.note = "three times"
    part.write(files / "list.knead")
    again = knead.Session.read(files / "list.knead")
    assert again == part and again.note == "three times"
    assert eval(repr(again), {"knead": knead}) == again


def test_a_session_file_keeps_its_remesh_events(files):
    text = '{"knead": 1}\n{"remesh": {"max_edge": 0.5}}\n{"mask": null}\n'
    (files / "remesh.knead").write_text(text)
    session = knead.Session.read(files / "remesh.knead")
    session.write(files / "remesh2.knead")
    assert (files / "remesh2.knead").read_text() == text


def test_errors_have_the_classes_and_words_of_the_command(files):
    assert issubclass(knead.InvalidInput, ValueError) and issubclass(knead.FileError, OSError)
    assert issubclass(knead.AccuracyError, RuntimeError) and issubclass(knead.Unavailable, RuntimeError)
    with pytest.raises(knead.FileError):
        knead.read(files / "absent.ply")
    (files / "bad.ply").write_text("ply\nformat ascii 1.0\nelement vertex 3\n")
    with pytest.raises(knead.InvalidInput, match="bad.ply"):
        knead.read(files / "bad.ply")
    (files / "bad.knead").write_text('{"knead": 1}\n{"tool": "bend"}\n')
    with pytest.raises(knead.InvalidInput, match=r"bad.knead:2: .*center"):
        knead.Session.read(files / "bad.knead")


def test_options_of_deform(sphere, session, files):
    v = sphere.vertices
    plain = knead.deform(v, session)
    assert bits(knead.deform(v, session, threads=1)) == bits(plain)
    exact = knead.deform(v, session, relative_tolerance=1e-10, precision="float64")
    size = np.linalg.norm(v.max(0) - v.min(0))
    assert 0 < np.abs(plain - exact).max() < 2e-5 * size
    assert np.abs(knead.deform(v, session, integrator="rk4") - exact).max() < 2e-5 * size
    back = knead.deform(exact, session, inverse=True, relative_tolerance=1e-10, precision="float64", diagonal=size)
    assert np.abs(back - v).max() < 1e-8
    session.write(files / "options.knead")
    for options, keywords in [
        (["--until", "1.5"], {"until": 1.5}),
        (["--inverse"], {"inverse": True}),
        (["--precision", "double", "--tolerance", "1e-9"], {"precision": "float64", "relative_tolerance": 1e-9}),
    ]:
        run("deform", files / "sphere.ply", files / "options.knead", "-o", files / "options.ply", "-q", *options)
        theirs = knead.read(files / "options.ply").vertices
        ours = knead.deform(knead.read(files / "sphere.ply").vertices, session, **keywords)
        kind = np.float64 if "double" in options else np.float32
        assert bits(ours.astype(kind)) == bits(theirs.astype(kind))


def test_diagonal_is_what_the_tolerance_is_relative_to(sphere, pull):
    v = sphere.vertices
    size = np.linalg.norm(v.max(0) - v.min(0))
    some = v[v[:, 1] > 0.8]
    whole = knead.deform(v, pull)[v[:, 1] > 0.8]
    assert bits(knead.deform(some, pull, diagonal=size)) == bits(whole)
    assert bits(knead.deform(some, pull)) != bits(whole)


def test_faces_where_strokes_read_the_surface(sphere, files):
    paint = knead.Paint(outer=0.3, depth=0.05, path=[[0, 1.1, 0], [0.3, 1, 0]])
    with pytest.raises(knead.InvalidInput, match="faces"):
        knead.deform(sphere.vertices, paint)
    moved = knead.deform(sphere.vertices, paint, sphere.faces)
    knead.Session(paint).write(files / "paint.knead")
    run("deform", files / "sphere.ply", files / "paint.knead", "-o", files / "painted.ply", "-q")
    assert bits(moved.astype(np.float32)) == bits(knead.read(files / "painted.ply").vertices.astype(np.float32))
    resolved = knead.Session(paint).resolve(sphere.vertices, sphere.faces)
    assert bits(knead.deform(sphere.vertices, resolved)) == bits(moved)


def test_faces_change_nothing_where_they_are_not_read(sphere, session):
    assert bits(knead.deform(sphere.vertices, session, sphere.faces)) == bits(knead.deform(sphere.vertices, session))


@pytest.mark.parametrize("in_place", [False, True])
@pytest.mark.parametrize("answer", ["false", "raises"])
def test_progress_ends_the_work(sphere, session, in_place, answer):
    seen = []

    def progress(fraction):
        seen.append(fraction)
        if answer == "raises":
            raise KeyError("enough")
        return False

    v = sphere.vertices.copy()
    out = v if in_place else np.full_like(v, 7)
    before = out.copy()
    if answer == "raises":
        with pytest.raises(KeyError, match="enough"):
            knead.deform(v, session, progress=progress, out=out)
    else:
        assert knead.deform(v, session, progress=progress, out=out) is None
    assert len(seen) == 1 and 0 <= seen[0] <= 1
    assert bits(out) == bits(before)


def test_progress_counts_to_one(sphere, session):
    seen = []
    knead.deform(sphere.vertices, session, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1


def test_flow(sphere, session):
    v = sphere.vertices
    flow = knead.Flow(session)
    assert len(flow) == 2
    assert bits(flow(v)) == bits(knead.deform(v, session))
    accurate = {"relative_tolerance": 1e-10, "precision": "float64"}
    moved = flow(v, **accurate)
    assert np.abs(flow.inverse()(moved, **accurate) - v).max() < 1e-8
    halves = flow.part(0.5, 2)(flow.part(0, 0.5)(v, **accurate), **accurate)
    assert np.abs(halves - moved).max() < 1e-8
    assert flow.part(0, 1) + flow.part(1, 2) == flow
    path = flow.path(v[:50], 5)
    assert path.shape == (5, 50, 3)
    assert bits(path[0]) == bits(v[:50]) and bits(path[-1]) == bits(flow(v[:50]))
    assert flow.path(v[:50], 1).shape == (1, 50, 3)


def test_velocity_is_the_derivative_of_the_path(sphere, session):
    flow = knead.Flow(session)
    x = sphere.vertices[::40]
    accurate = {"relative_tolerance": 1e-12, "precision": "float64"}
    for time in (0.3, 1.0, 1.6):
        h = 1e-4
        now = flow.part(0, time)(x, **accurate)
        later = flow.part(time, time + h)(now, **accurate)
        assert np.abs((later - now) / h - flow.velocity(now, time)).max() < 5e-3
    with pytest.raises(knead.InvalidInput):
        flow.velocity(x, 2.5)


def test_jacobian_is_the_derivative_of_the_flow_and_keeps_volume(sphere):
    strokes = [
        knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5),
        knead.Rotate(center=[0, 0, 0], axis=[0, 1, 0], angle_deg=50, inner=0.3, outer=1.2),
        knead.Pins(points=[[1, 0, 0], [0, 0, 1]], to=[[1.2, 0.1, 0], [0, 0, 1]], radius=1.5),
        knead.Grid(origin=[0, 1, 0], spacing=0.5, counts=[1, 1, 1], coefficients="AAAAAAAAAAAAAAAAAAAAAAAAAAAAANA/"),
    ]
    flow = knead.Flow(knead.Session(strokes))
    x = sphere.vertices[::60]
    accurate = {"relative_tolerance": 1e-12, "precision": "float64"}
    jacobian = flow.jacobian(x, **accurate)
    assert jacobian.shape == (len(x), 3, 3)
    assert np.abs(np.linalg.det(jacobian) - 1).max() < 1e-9
    h = 1e-5
    for axis in range(3):
        e = np.zeros(3)
        e[axis] = h
        difference = (flow(x + e, **accurate) - flow(x - e, **accurate)) / (2 * h)
        assert np.abs(difference - jacobian[:, :, axis]).max() < 1e-4
    there_and_back = (flow + flow.inverse()).jacobian(x, **accurate)
    assert np.abs(there_and_back - np.eye(3)).max() < 1e-6


def test_remesh(sphere, session, files):
    result = knead.remesh(sphere.vertices, sphere.faces, session, max_edge=0.2)
    session.write(files / "remeshed.knead")
    run("deform", files / "sphere.ply", files / "remeshed.knead", "--remesh", "--max-edge", "0.2", "-o",
        files / "remeshed.ply", "-q")
    theirs = knead.read(files / "remeshed.ply")
    assert np.array_equal(theirs.faces, result.faces)
    assert bits(theirs.vertices.astype(np.float32)) == bits(result.vertices.astype(np.float32))
    assert result.face_source.shape == (len(result.faces),) and result.face_source.max() < len(sphere.faces)
    assert result.report["vertices"] == len(result.vertices)
    whole = knead.remesh(sphere.vertices, sphere.faces, max_edge=0.05)
    assert whole.report["splits"] > 0 and len(whole.vertices) > len(sphere.vertices)
    with pytest.raises(knead.InvalidInput, match="max_edge"):
        knead.remesh(sphere.vertices, sphere.faces, max_edge=-1)
    with pytest.raises(knead.AccuracyError):
        knead.remesh(sphere.vertices, sphere.faces, session, max_edge=1e-5, max_vertices=5000)
    assert result.report["remesh"]["out_of_time"] is False
    for moved_by in (session, None):
        hasty = knead.remesh(sphere.vertices, sphere.faces, moved_by, max_edge=0.05, seconds=1e-9)
        assert (hasty.report if moved_by is None else hasty.report["remesh"])["out_of_time"] is True
        same = knead.remesh(sphere.vertices, sphere.faces, moved_by, max_edge=0.05, seconds=1e4)
        without = knead.remesh(sphere.vertices, sphere.faces, moved_by, max_edge=0.05)
        assert bits(same.vertices) == bits(without.vertices) and len(hasty.vertices) < len(same.vertices)
    with pytest.raises(knead.InvalidInput, match="seconds"):
        knead.remesh(sphere.vertices, sphere.faces, session, seconds=0)


def test_check_has_the_keys_and_values_of_the_command(sphere, files):
    theirs = json.loads(run("check", files / "sphere.ply", "--json"))
    ours = knead.check(sphere.vertices, sphere.faces)
    assert list(ours) == list(theirs)
    for key in set(ours) - {"format", "attributes", "notes"}:
        assert ours[key] == theirs[key], key


def test_certify(sphere, session, files):
    v = sphere.vertices
    moved = knead.deform(v, session)
    ours = knead.certify(v, moved, sphere.faces, session)
    session.write(files / "certify.knead")
    report = run("deform", files / "sphere.ply", files / "certify.knead", "--check", "--json", "-o", files / "c.ply")
    theirs = json.loads(report)["certificate"]
    assert list(ours) == list(theirs)
    assert ours["crossings_after"] == theirs["crossings_after"] == 0
    assert abs(ours["volume_error"] - theirs["volume_error"]) < 1e-6
    assert abs(ours["distance_max"] - theirs["distance_max"]) < 1e-6
    assert ours["motion_outside"] == 0
    wrong = moved.copy()
    wrong[0] *= 1.2
    assert knead.certify(v, wrong, sphere.faces, session)["distance_max"] > 5 * ours["distance_max"]


def test_render(sphere, session):
    try:
        picture = knead.render(sphere, session=session, size=(160, 120))
    except knead.Unavailable as error:
        pytest.skip(str(error))
    assert picture.shape == (120, 160, 3) and picture.dtype == np.uint8
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    plain = knead.render(sphere.vertices, sphere.faces, size=(160, 120), view=(30, 20))
    assert not np.array_equal(plain, picture)
    clear = knead.render(sphere, size=(64, 64), background="transparent")
    assert clear.shape == (64, 64, 4) and clear[0, 0, 3] == 0 and clear[32, 32, 3] == 255
    with pytest.raises(knead.InvalidInput, match="material"):
        knead.render(sphere, material="gold")


def test_workbench(sphere, session, pull):
    bench = knead.Workbench(sphere.vertices, sphere.faces)
    view = bench.vertices
    assert not view.flags.writeable
    bench.set_live([pull])
    assert bits(view) == bits(knead.deform(sphere.vertices, pull))
    assert np.shares_memory(view, bench.vertices)
    bench.set_live(session)
    bench.finish()
    assert bits(bench.vertices) == bits(knead.deform(sphere.vertices, session))
    assert bench.session == session
    assert bench.undo() and bits(bench.vertices) == bits(sphere.vertices)
    assert bench.redo() and bench.session == session
    assert not bench.redo()
    torn = knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[1, 0, 0], width=1, angle_deg=70, radius=0.5)
    before = bits(bench.vertices)
    with pytest.raises(knead.InvalidInput, match="radius"):
        bench.set_live([torn])
    assert bits(bench.vertices) == before


def test_several_threads(sphere, session):
    expected = bits(knead.deform(sphere.vertices, session))
    results = [None] * 8

    def work(i):
        results[i] = bits(knead.deform(sphere.vertices, session))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected] * 8


def test_an_endless_path_line_is_an_accuracy_error():
    bend = knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[1, 0, 0], width=1, angle_deg=170)
    far = np.array([[0, 0, 0], [0.1, 0, 1e4]])
    with pytest.raises(knead.AccuracyError, match="infinity"):
        knead.deform(far, bend, diagonal=1, out=far)
    assert far[1, 2] == 1e4
    still = knead.Implicit(path=[[9, 9, 9], [9, 9, 8]], inner=0.1, outer=0.2)
    with pytest.raises(knead.AccuracyError, match="^session:3: "):
        knead.deform(far, [still, bend], diagonal=1)
