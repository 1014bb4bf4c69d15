"""Sessions: lists of strokes, and their files."""

import collections.abc
import os

from . import _knead
from ._arrays import faces_for
from ._strokes import Stroke, _wrap, stroke


class Session(collections.abc.MutableSequence):
    """A list of strokes, with the shape that it was made on and a note.

    strokes: strokes, or dicts as knead.stroke takes them.
    mesh: path of the shape, relative to the session's file; note: text for people.

    Strokes of stamps name files, relative to the folder of the session's file (`path`), or the current folder.
    """

    def __init__(self, strokes=(), mesh=None, note=None):
        if isinstance(strokes, (Stroke, dict)):
            strokes = [strokes]
        self._strokes = [stroke(s) for s in strokes]
        self.mesh = None if mesh is None else os.fspath(mesh)
        self.note = note
        self.path = None

    @classmethod
    def read(cls, path):
        """Reads a .knead file. Raises FileError, and InvalidInput with file, line and key."""
        native = _knead.read_session(os.fspath(path))
        self = cls(mesh=native.mesh, note=native.note)
        self._strokes = [_wrap(s) for s in native.strokes]
        self.path = os.fspath(path)
        return self

    @classmethod
    def parse(cls, text, name="session"):
        """Returns the session in the text of a .knead file; `name` stands in messages, and stamps are relative to it."""
        native = _knead.parse_session(str(text), os.fspath(name))
        self = cls(mesh=native.mesh, note=native.note)
        self._strokes = [_wrap(s) for s in native.strokes]
        self.path = os.fspath(name)
        return self

    def text(self):
        """Returns the text of a .knead file; parse() gives an equal session."""
        return self._native().text()

    def write(self, path):
        """Writes a .knead file, whole or not at all. Raises FileError."""
        self._native().write(os.fspath(path))

    def resolve(self, vertices, faces=None, *, threads=0):
        """Returns the session as one that reads no surface: a flow for any points.

        Raises InvalidInput for a stroke that this shape cannot take.
        """
        strokes, _ = _knead.resolve(vertices, faces_for(vertices, faces), self._native(), threads)
        resolved = Session(note=self.note)
        resolved._strokes = [_wrap(s) for s in strokes]
        return resolved

    def _native(self):
        native = _knead.Session([s._native for s in self._strokes], self.path or "")
        native.mesh = self.mesh
        native.note = self.note
        return native

    def __len__(self):
        return len(self._strokes)

    def __getitem__(self, index):
        if not isinstance(index, slice):
            return self._strokes[index]
        part = Session(self._strokes[index], self.mesh, self.note)
        part.path = self.path
        return part

    def __setitem__(self, index, value):
        self._strokes[index] = [stroke(s) for s in value] if isinstance(index, slice) else stroke(value)

    def __delitem__(self, index):
        del self._strokes[index]

    def insert(self, index, value):
        self._strokes.insert(index, stroke(value))

    def __eq__(self, other):
        if not isinstance(other, Session):
            return NotImplemented
        return self._native().text() == other._native().text()

    __hash__ = None

    def __repr__(self):
        rest = "".join(f", {k}={v!r}" for k, v in (("mesh", self.mesh), ("note", self.note)) if v is not None)
        return f"knead.Session({self._strokes!r}{rest})"


def native_session(session):
    """Returns the native session of a Session, a stroke, or an iterable of strokes."""
    return (session if isinstance(session, Session) else Session(session))._native()
