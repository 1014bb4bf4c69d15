"""Deforming points, remeshing, the certificate, pictures and the workbench."""

import json
import math
import operator
import os
import typing

from . import _knead
from ._arrays import faces_for
from ._session import Session, derivative_request, native_session
from ._shapes import Shape, cell_blocks, solid_blocks, volume_cells
from ._strokes import Stroke, _wrap


def _number(value, name):
    """Returns a float; of whole numbers that are too large for one, raises InvalidInput."""
    try:
        return float(value)
    except OverflowError:
        raise _knead.InvalidInput(f"{name} is too large a number") from None


def _accuracy(relative_tolerance=1e-5, precision="float32", integrator="tsit5", threads=0, diagonal=None):
    length = None if diagonal is None else _number(diagonal, "diagonal")
    tolerance = _number(relative_tolerance, "relative_tolerance")
    return _knead.Accuracy(tolerance, str(precision), str(integrator), operator.index(threads), length)


def deform(
    vertices,
    session,
    faces=None,
    *,
    relative_tolerance=1e-5,
    precision="float32",
    integrator="tsit5",
    threads=0,
    inverse=False,
    until=None,
    diagonal=None,
    progress=None,
    out=None,
    also=None,
    patches=None,
    cells=None,
):
    """Returns the vertices deformed by a session: (n, 3) float64, or float32 if `vertices` is float32.

    vertices: array-like (n, 3) of any real type, or an object with such .vertices or .points. It is not changed.
    session: a Session, a stroke, or a sequence of strokes.
    faces: integers (m, 3), or a sequence of faces with any number of corners; needed where a stroke reads the surface
        (paint along a path, stamps, vertex numbers, relax). A limit cylinder is then checked against them.
    relative_tolerance: position error of one path line over one segment, relative to `diagonal`; above 0.
    precision: "float32" or "float64", in which fields are evaluated. Positions are float64 in both cases.
    integrator: "tsit5" or "rk4".
    threads: 0 means all; the result does not depend on it.
    inverse: applies the session backwards: takes deformed vertices back.
    until: the number of strokes to apply; 2.5 is two and half of the third.
    diagonal: the length that the tolerance is relative to; by default the diagonal of the box of `vertices`.
    progress: progress(fraction) is called a few times a second. If it returns False, the work ends, nothing is written
        and deform returns None; if it raises, that error is raised here.
    out: an array (n, 3) of float64 or float32 to write into and return. It may be `vertices`: a C-contiguous float64
        array is then moved in place, without a copy unless `progress` is given.
    also: a sequence of other shapes or points, such as clothes and eyes, that one flow moves along: the result is then a
        list of `vertices`, deformed, and of each of them. Strokes that read a surface read that of `vertices`.
    patches, cells: of a volume mesh; by default those of a Shape that was read from a file of gmsh, SU2 or OpenFOAM, and
        the cells of a mesh of meshio or pyvista. patches: for a session with walls, a dict of names and arrays as
        Shape.patches, faces of any number of corners. cells: as for check_cells, and in a plane of one z triangles (m, 3)
        and quadrilaterals (m, 4). Where a cell would be inverted, points inside leave the flow, with a warning; without
        cells none is judged.

    Raises InvalidInput (a ValueError) for values that cannot be used, with the first index for a coordinate that is not
    finite; TypeError for other types; AccuracyError if a path line runs to infinity, or a cell would be inverted. Ctrl-C ends the work and leaves `out` as it was. The GIL is released; calls from several threads on
    different arrays are safe.
    """
    accuracy = _accuracy(relative_tolerance, precision, integrator, threads, diagonal)
    has_walls = isinstance(session, Session) and bool(session.walls)
    if has_walls and (faces is not None or also is not None):
        raise _knead.InvalidInput("walls are those of one volume mesh; leave out faces and also")
    faces = None if has_walls else faces_for(vertices, faces)
    if also is None:
        native = session._native(walls=True) if has_walls else native_session(session)
        parts = _mesh_parts(vertices, patches, cells)
        how = (accuracy, bool(inverse), until, progress, out)
        if parts is None and not has_walls:
            return _knead.deform(vertices, native, faces, *how)
        return _knead.deform_volume(vertices, native, faces, parts or _knead.parts_from([], [], vertices, False), *how)
    import numpy as np

    if isinstance(also, np.ndarray) or hasattr(also, "vertices") or hasattr(also, "points"):
        raise TypeError("also must be a sequence of shapes, such as [clothes, eyes]")
    if diagonal is None:
        points = next((getattr(vertices, name) for name in ("vertices", "points") if hasattr(vertices, name)), vertices)
        accuracy = _accuracy(relative_tolerance, precision, integrator, threads, float(np.linalg.norm(np.ptp(points, axis=0))))
    whole = session if isinstance(session, Session) else Session(session)
    flow = whole if inverse else whole.resolve(vertices, faces, threads=threads)
    results = []
    for shape, surface, to in [(vertices, faces, out), *((other, None, None) for other in also)]:
        moved = _knead.deform(shape, native_session(flow), surface, accuracy, bool(inverse), until, progress, to)
        if moved is None:
            return None
        results.append(moved)
    return results


def _mesh_parts(vertices, patches, cells):
    """Returns the native patches and cells of a volume mesh; None for another shape."""
    import numpy as np

    if patches is None and cells is None and isinstance(vertices, Shape):
        return vertices._mesh_parts()
    points = getattr(vertices, "vertices", getattr(vertices, "points", vertices))
    is_flat = cells is not None and len(points) > 0 and float(np.ptp(np.asarray(points)[:, 2])) == 0
    blocks = cell_blocks(cells, is_flat) if is_flat else solid_blocks(points, volume_cells(vertices) if cells is None else cells)
    if not blocks and patches is None:
        return None
    named = {str(name): np.asarray(numbers) for name, numbers in dict(patches or {}).items()}
    for name, numbers in named.items():
        if numbers.dtype.kind not in "iu":
            raise TypeError(f"the patch {name!r} must be an array of whole numbers, got dtype {numbers.dtype}")
    return _knead.parts_from(list(named.items()), blocks, points, is_flat)


class _Made(typing.NamedTuple):
    """A flow of the library, and the call that makes it again."""

    native: object
    how: tuple


class Flow:
    """A deformation as a value, without a mesh: a map of all space that keeps volume and can be inverted.

    Made from a Session (or strokes) that reads no surface; see Session.resolve. `len(flow)` is its number of segments,
    `flow + other` applies `other` after it.
    """

    def __init__(self, session=()):
        if isinstance(session, _Made):
            self._native, self._how = session
            return
        session = Session(session) if not isinstance(session, Session) else session[:]
        self._native, self._how = _knead.Flow(session._native()), (Flow, (session,))

    def __reduce__(self):
        return self._how

    def __call__(
        self,
        points,
        *,
        relative_tolerance=1e-5,
        precision="float32",
        integrator="tsit5",
        threads=0,
        diagonal=None,
        progress=None,
        out=None,
    ):
        """Returns the points where the flow takes them: (n, 3). The keywords are those of knead.deform."""
        accuracy = _accuracy(relative_tolerance, precision, integrator, threads, diagonal)
        return self._native.move(points, accuracy, progress, out)

    def inverse(self):
        """Returns the flow that moves every point back."""
        return Flow(_Made(self._native.inverse(), (Flow.inverse, (self,))))

    def part(self, begin, end):
        """Returns the flow from one moment to another, in segments from 0 to len(flow); fractions are allowed. Backwards
        if end < begin."""
        return Flow(_Made(self._native.between(begin, end), (Flow.part, (self, begin, end))))

    def path(self, points, n, **accuracy):
        """Returns the places of the points at n moments, evenly spaced from the beginning to the end: (n, len, 3).

        n = 1: the end alone. Keywords: relative_tolerance, precision, integrator, threads, diagonal.
        """
        return self._native.path(points, n, _accuracy(**accuracy))

    def velocity(self, points, time):
        """Returns the velocity field at the points at a time from 0 to len(flow): (len, 3), in lengths per segment."""
        return self._native.velocity(points, time)

    def jacobian(self, points, **accuracy):
        """Returns the derivative of the map at each of the points: (len, 3, 3), row i that of coordinate i.

        Its determinant is 1 up to the tolerance. Keywords as for path().
        """
        return self._native.jacobian(points, _accuracy(**accuracy))

    def jvp(self, points, direction, *, progress=None, **options):
        """Returns the deformed points, and how they move when the coefficients of lattices and grids change.

        direction: for each segment an array as vjp() returns it, or None. options: the other keywords of Session.jvp.
        Returns two arrays (n, 3) of float64, or None if `progress` returned False. Raises InvalidInput for an array of
        another shape.
        """
        return _knead.flow_jvp(self._native, points, direction, derivative_request(**options), progress)

    def vjp(self, points, gradient, *, progress=None, **options):
        """Returns the derivatives of a number that depends on the deformed points, at one cost for all coefficients.

        gradient: array-like (n, 3), the derivatives with respect to the deformed points. options: the other
        keywords of Session.jvp. Returns an array (n, 3), with respect to the points, and for each segment an array with respect to
        the displacements of its lattice (nx, ny, nz, 3), or the coefficients of its grid (nz, ny, nx, 3), those at the
        beginning and at the end if they change (2, nz, ny, nx, 3), or None. None if `progress` returned False.
        """
        return _knead.flow_vjp(self._native, points, gradient, derivative_request(**options), progress)

    def __len__(self):
        return len(self._native)

    def __add__(self, other):
        if not isinstance(other, Flow):
            return NotImplemented
        return Flow(_Made(self._native.joined(other._native), (Flow.__add__, (self, other))))

    def __eq__(self, other):
        return self._native == other._native if isinstance(other, Flow) else NotImplemented

    __hash__ = None

    def __repr__(self):
        return f"<knead.Flow: {len(self)} segments>"


def _frames(vertices, faces, n, ease, hold, fps=24):
    faces = faces_for(vertices, faces)
    return faces, _knead.Timing(operator.index(n), str(ease), operator.index(hold), _number(fps, "fps"))


def frames(vertices, session, n, faces=None, *, ease="linear", hold=0, progress=None, **accuracy):
    """Returns the vertices at n moments of a session, evenly spaced in time: (n, len, 3) float64.

    The first is the undeformed shape, the last the result. vertices, session, faces, progress: as for deform; a Shape
    brings its faces. ease: "linear", or "smooth": slowly at both ends. hold: how often the first and the last frame are
    repeated. Strokes take their `duration`. If the session remeshes, every frame has the vertices of the result. Keywords:
    relative_tolerance, precision, integrator, threads, diagonal. Returns None if `progress` returned False. Raises as
    deform.
    """
    faces, how = _frames(vertices, faces, n, ease, hold)
    return _knead.frames(vertices, native_session(session), faces, _accuracy(**accuracy), how, progress)


def animate(path, vertices, session, n, faces=None, *, fps=24, ease="linear", hold=0, progress=None, **accuracy):
    """Writes the frames that frames() returns to one file: .pc2, .mdd, .glb, .usda or .pvd, whole or not at all.

    fps: frames a second. The file holds a plain mesh; `knead deform --frames` keeps the materials of a glTF file. Returns
    False if `progress` returned False, and writes nothing then. Raises FileError, and as deform.
    """
    faces, how = _frames(vertices, faces, n, ease, hold, fps)
    return _knead.animate(os.fspath(path), vertices, native_session(session), faces, _accuracy(**accuracy), how, progress)


def write_frames(path, frames, faces=None, *, fps=24):
    """Writes frames, an array (n, len, 3) or a sequence of (len, 3), to one file as animate() does."""
    _knead.write_frames(os.fspath(path), list(frames), faces, _number(fps, "fps"))


class Remeshed:
    """A remeshed shape.

    vertices: (n, 3) float64; faces: (m, 3) uint32, or a list of arrays; face_source: (m,) uint32, for each face the face
    of the input that it lies in; report: a dict, the keys of `knead deform --report`, or without a session of
    `knead remesh --json`.
    """

    def __init__(self, vertices, faces, face_source, report):
        self.vertices = vertices
        self.faces = faces
        self.face_source = face_source
        self.report = report

    def __repr__(self):
        return f"<knead.Remeshed: {len(self.vertices)} vertices, {len(self.faces)} faces>"


def remesh(
    vertices,
    faces=None,
    session=None,
    *,
    max_edge=None,
    max_angle_deg=None,
    max_chord=None,
    min_edge=None,
    iterations=None,
    max_vertices=None,
    seconds=None,
    relative_tolerance=1e-5,
    precision="float32",
    integrator="tsit5",
    threads=0,
    progress=None,
):
    """Refines and improves a mesh: without a session where it lies, with one while the session deforms it.

    max_edge, min_edge: lengths; max_angle_deg: degrees, above 0 to 180; max_chord: a fraction of the diagonal, 0 to 1;
    iterations: rounds, 0 to 100; max_vertices: the most that the mesh may grow to. None: chosen from the shape.
    seconds: above 0; after that time a stroke (without a session: the call), the best mesh so far is kept, and the report's
        "out_of_time" is true. The result then depends on the machine. None: no limit.
    Other keywords as for deform. Returns Remeshed, or None if `progress` returned False.

    Raises InvalidInput, and AccuracyError where the mesh would need more than max_vertices,
    or where triangles cross that did not before and remeshing cannot end that.
    """
    given = {
        "max_edge": max_edge,
        "max_angle_deg": max_angle_deg,
        "max_chord": max_chord,
        "min_edge": min_edge,
        "iterations": iterations,
        "max_vertices": max_vertices,
    }
    limit = math.inf if seconds is None else _number(seconds, "seconds")
    if not limit > 0:
        raise _knead.InvalidInput(f"seconds must be above 0, got {seconds}")
    faces = faces_for(vertices, faces)
    settings = _knead.RemeshSettings(**{key: value for key, value in given.items() if value is not None})
    if session is None:
        result = _knead.remesh_whole(vertices, faces, settings, limit, threads, progress)
    else:
        accuracy = _accuracy(relative_tolerance, precision, integrator, threads)
        result = _knead.remesh_moved(vertices, faces, native_session(session), settings, limit, accuracy, progress)
    if result is None:
        return None
    return Remeshed(*result[:3], json.loads(result[3]))


def certify(
    before,
    after,
    faces,
    session,
    *,
    relative_tolerance=1e-5,
    precision="float32",
    integrator="tsit5",
    threads=0,
    progress=None,
):
    """Returns the certificate of a result, as a dict: crossings, flips, volume, angles, distance to the exact image.

    before, after: (n, 3), the vertices before and after the session; faces: those of both. The keys are those of
    `certificate` in the report of `knead deform --check`. Takes several times as long as the deformation. The keywords
    are those that deform was called with.
    """
    accuracy = _accuracy(relative_tolerance, precision, integrator, threads)
    text = _knead.certify(before, after, faces_for(before, faces), native_session(session), accuracy, progress)
    return None if text is None else json.loads(text)


def render(
    shape,
    faces=None,
    *,
    session=None,
    size=(800, 600),
    view=(30, 20),
    up="y",
    perspective=25,
    background="white",
    material="clay",
    ground=True,
    wireframe=False,
    flat=False,
    cavity=False,
    occlusion=False,
):
    """Returns a picture: (height, width, 3) uint8, or 4 channels with background="transparent".

    shape: a Shape, or vertices (n, 3) with `faces`; without faces a point cloud. session: draws its tools.
    size: (width, height) in pixels, 16 to 8192 each. view: (azimuth, elevation) in degrees, from the front towards +x.
    up: "y" or "z". perspective: the angle of view in degrees, 0 for none. background: "white", "transparent", "light",
    "dark", "gradient" or "#rrggbb". material: "clay", or a name as "porcelain".

    Raises Unavailable where there is no OpenGL.
    """
    if _knead.render is None:
        raise _knead.Unavailable("this build of knead has no renderer; build it where EGL, epoxy and stb are installed")
    faces = faces_for(shape, faces)
    _note_rendering()
    look = _knead.Look()
    width, height = size
    if not all(16 <= int(n) <= 8192 for n in (width, height)):
        raise _knead.InvalidInput(f"size must be (width, height) in pixels, 16 to 8192 each, got {size}")
    look.width, look.height = int(width), int(height)
    look.azimuth_deg, look.elevation_deg = (float(angle) for angle in view)
    if not (math.isfinite(look.azimuth_deg) and abs(look.elevation_deg) <= 90):
        raise _knead.InvalidInput(f"view must be (azimuth, elevation) in degrees, as (30, 20), got {view}")
    if not (isinstance(up, str) and up in ("y", "z")):
        raise _knead.InvalidInput(f'up must be "y" or "z", got {up!r}')
    look.z_up = up == "z"
    if perspective != 0 and not 1 <= perspective <= 120:
        raise _knead.InvalidInput(f"perspective must be from 1 to 120 degrees, or 0 for none, got {perspective}")
    look.perspective = perspective
    look.background, look.material = background, material
    look.ground, look.wireframe, look.flat = bool(ground), bool(wireframe), bool(flat)
    look.cavity, look.occlusion = bool(cavity), bool(occlusion)
    return _knead.render(shape, faces, _flows_of(session, shape, faces), look)


def picture(shape, session=None):
    """Returns a small picture as PNG bytes for notebooks; None where there is no OpenGL."""
    import struct
    import zlib

    try:
        pixels = render(shape, session=session, size=(480, 360))
    except _knead.Unavailable:
        return None
    height, width, _ = pixels.shape
    parts = (
        (b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in pixels))),
        (b"IEND", b""),
    )
    chunks = [struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in parts]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


_rendering = []  # the process that has rendered first


def _note_rendering():
    """OpenGL does not survive a fork: a process that is forked after a picture would wait for ever."""
    _rendering[:] = _rendering or [os.getpid()]
    if _rendering[0] != os.getpid():
        raise _knead.Unavailable('render has been used before this process was forked; start it by "spawn"')


def _flows_of(session, shape, faces):
    """Returns a flow for each stroke of a session; resolves those that read the surface."""
    if session is None:
        return []
    session = session if isinstance(session, Session) else Session(session)
    try:
        return [_knead.Flow(session[i : i + 1]._native()) for i in range(len(session))]
    except _knead.InvalidInput:
        resolved = session.resolve(shape, faces)
        return [_knead.Flow(resolved[i : i + 1]._native()) for i in range(len(resolved))]


class Workbench:
    """A shape in an editor: strokes that are applied while they are made, undone and redone.

    vertices: (n, 3); faces: as for deform. folder: the paths of stamps are relative to it. The shape always has the
    values that deform gives for the session. For one thread at a time.
    """

    def __init__(self, vertices, faces=None, *, folder=""):
        self._native = _knead.Workbench(vertices, faces_for(vertices, faces), folder)

    def __reduce__(self):
        raise TypeError("a Workbench cannot be copied or pickled; send its session, vertices and faces")


    def set_live(self, strokes):
        """Replaces the strokes of the current gesture. If the new list only extends the old one, only the new part is
        computed. An empty list gives the gesture up. Raises InvalidInput where the shape cannot take a stroke; the shape
        is then as before."""
        strokes = [strokes] if isinstance(strokes, (Stroke, dict)) else strokes
        self._native.set_live([s._native for s in Session(strokes)])

    def finish(self):
        """Appends the current gesture to the history."""
        self._native.finish()

    def undo(self):
        """Takes back the current gesture, or the last entry of the history. Returns False if there was none."""
        return self._native.undo()

    def redo(self):
        """Repeats what was undone last. Returns False if there was nothing."""
        return self._native.redo()

    @property
    def vertices(self):
        """The vertices now: a read-only view without a copy, which the next call changes."""
        return self._native.vertices()

    @property
    def faces(self):
        """The faces now; other ones after a stroke that remeshes."""
        return self._native.faces()

    @property
    def session(self):
        """The strokes in effect, the current gesture included."""
        session = Session()
        session._strokes = [_wrap(s) for s in self._native.strokes()]
        return session
