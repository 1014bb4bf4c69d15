# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of a mesh in the library, kept from one stroke to the next."""

import numpy as np

from . import rebuild, shape, shown, state
from .native import knead


class Live:
    """A mesh from its base positions on: the library's Workbench with the session, and what a pointer touches."""

    def __init__(self, base, faces, frame):
        self.base, self.faces, self.frame = base, faces, frame
        self.entered = frame.enter(base)
        self.size = float(np.linalg.norm(np.ptp(self.entered, axis=0))) or 1.0
        self._bench = knead.Workbench(self.entered, faces)
        self._texts = [""]  # of the session after each entry of the bench's history
        self._surface, self._is_stale = None, False
        self.link = None  # of a posed mesh, since the beginning of the current stroke

    def go_to(self, text):
        """Makes the shape what this session gives."""
        if text not in self._texts:
            self._undo_to("")
            session = state.parse(text)
            rebuild.check_session(session)
            self._bench.set_live(session)
            self._bench.finish()
            self._texts.append(text)
            self._is_stale = True
        else:
            self._undo_to(text)

    def _undo_to(self, text):
        self._bench.set_live([])
        while self._texts[-1] != text:
            self._bench.undo()
            self._texts.pop()
            self._is_stale = True

    @property
    def text(self):
        """The session so far, without the current stroke."""
        return self._texts[-1]

    @property
    def coordinates(self):
        """The coordinates of now as float32, in the object's own space, as they are shown."""
        return self.frame.leave(self._bench.vertices, self.entered, self.base)

    @property
    def vertices(self):
        """The positions of now in the space of the session; a copy."""
        return np.array(self._bench.vertices)

    @property
    def surface(self):
        """The surface before the current stroke, in the space of the session."""
        if self._surface is None:
            self._surface = knead.Surface(self._bench.vertices, self.faces)
        elif self._is_stale:
            self._surface.move(self._bench.vertices)
        self._is_stale = False
        return self._surface

    @property
    def has_surface(self):
        return self._surface is not None and not self._is_stale

    def set_strokes(self, strokes):
        """Replaces the current gesture. Raises knead.InvalidInput and leaves the shape where it cannot be."""
        self._bench.set_live(strokes)

    def finish(self, strokes):
        """Appends strokes to the session, and returns that."""
        self._bench.set_live(strokes)
        session = state.parse(self.text)
        session.extend(strokes)
        self._bench.finish()
        self._texts.append(session.text())
        self._is_stale = True
        return session


_kept = {}  # the one that was used last: its key, and the Live


def _key(obj, base, frame, faces):
    corners = faces if isinstance(faces, np.ndarray) else np.concatenate([*faces, [len(f) for f in faces]] or [[0]])
    matrix = None if frame.matrix is None else frame.matrix.tobytes()
    return obj.data.name_full, shape.key_name(obj), shape.fingerprint(base), hash(corners.tobytes()), matrix


def begin(obj):
    """Returns the Live of an object, with its session as it is now. Raises Refusal where strokes cannot be applied."""
    state.require_mesh(obj)
    shown.require_seen(obj)
    data = obj.data.knead
    extends = state.extends(obj)
    base = shape.read_base(obj.data) if extends else shown.read(obj)
    frame = state.frame_of(obj.data) if extends else shape.Frame()
    faces = shape.faces(obj.data)
    if len(faces) == 0:
        raise state.Refusal("The mesh has no faces to touch")
    key = _key(obj, base, frame, faces)
    live = _kept.get(key)
    if live is None:
        _kept.clear()
        live = _kept[key] = Live(base, faces, frame)
    live.link = shown.Link(obj) if shown.is_posed(obj) else None
    live.go_to(data.session if extends else "")
    return live


def touched(obj):
    """Returns the kept Live if it may have the surface of the object as it is, else None. Does not compare."""
    for key, live in _kept.items():
        if key[0] == obj.data.name_full and live.has_surface and live.text == obj.data.knead.session:
            return live
    return None


def show(obj, live):
    """Writes the shape to the mesh."""
    shape.write(obj, live.coordinates if live.link is None else live.link.nearly(live.coordinates))


def keep(operator, obj, live, strokes, before):
    """Ends a stroke: the mesh and its session have it. `before`: the coordinates before the stroke."""
    coordinates = live.coordinates if live.link is None else live.link.follow(live.coordinates)
    begins = live.text == ""
    had = bool(obj.data.knead.session)
    session = live.finish(strokes)
    if begins:
        shape.write(obj, before)
        if had:
            operator.report({"WARNING"}, "The mesh was changed elsewhere: its session begins anew")
        state.begin(obj)
    state.keep(obj, session, coordinates)


def forget():
    _kept.clear()
