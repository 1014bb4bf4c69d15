"""Sessions: lists of strokes, and their files."""

import collections.abc
import json
import operator
import os

from . import _knead
from ._arrays import faces_for
from ._strokes import Stroke, _plain, _stroke_with, _wrap


def _read_header(key, value):
    """Returns the native session that has this in its header."""
    try:
        header = json.dumps({"knead": 1, key: value}, default=_plain, allow_nan=False)
    except ValueError:
        raise _knead.InvalidInput(f"{key} has a number that is not finite") from None
    return _knead.parse_session(header + "\n", "session")


def _native_parameters(parameters):
    """Returns native parameters of numbers, or tuples of a number and its bounds, by name."""
    if not parameters:
        return []

    def described(given):
        if not isinstance(given, (tuple, list)):
            return given
        value, least, greatest = given
        return {k: v for k, v in (("value", value), ("min", least), ("max", greatest)) if v is not None}

    return _read_header("parameters", {str(name): described(given) for name, given in dict(parameters).items()}).parameters


def _real(number):
    """Returns a float; of whole numbers that are too large for one, raises InvalidInput."""
    try:
        return float(number)
    except OverflowError:
        raise _knead.InvalidInput("a number is too large") from None


def _length(diagonal):
    return None if diagonal is None else _real(diagonal)


def derivative_request(relative_tolerance=1e-8, threads=0, diagonal=None):
    """Returns the options of Session.jvp in numbers of the library."""
    return _knead.DerivativeRequest(_real(relative_tolerance), operator.index(threads), _length(diagonal))


class Session(collections.abc.MutableSequence):
    """A list of strokes, with the shape that it was made on and a note.

    strokes: strokes, or dicts as knead.stroke takes them.
    mesh: path of the shape, relative to the session's file; note: text for people.
    parameters: a dict of names and values; in the place of a value there may be a tuple (value, least, greatest) of which
        the bounds may be None. In strokes that are dicts, the text "$name" stands for the number.
    walls: dicts as in the header of a session's file, such as {"patch": "inlet", "hold": True}. They are patches of a
        volume mesh; knead.deform takes such a session, and nothing else does.

    `session(length=0.3)` returns the session with other values of parameters.

    Strokes of stamps name files, relative to the folder of the session's file (`path`), or the current folder.
    """

    def __init__(self, strokes=(), mesh=None, note=None, parameters=None, walls=None):
        if isinstance(strokes, (Stroke, dict)):
            strokes = [strokes]
        if isinstance(strokes, (str, bytes, os.PathLike)):
            raise TypeError(f"{strokes!r} is the path of a session; read it by knead.Session.read")
        if not hasattr(strokes, "__iter__"):
            raise TypeError(f"a session is made of strokes, got {type(strokes).__name__}; a Flow moves points by flow(points)")
        named = isinstance(strokes, Session) and parameters is None
        self._parameters = strokes._parameters if named else _native_parameters(parameters)
        if walls is None:
            self._walls = strokes._walls if isinstance(strokes, Session) else []
        else:
            self._walls = _read_header("walls", list(walls)).walls
        self._strokes = [self._stroke(s) for s in strokes]
        self.mesh = None if mesh is None else os.fspath(mesh)
        self.note = note
        self.path = None

    @classmethod
    def read(cls, path):
        """Reads a .knead file. Raises FileError, and InvalidInput with file, line and key."""
        self = cls()._take(_knead.read_session(os.fspath(path)))
        self.path = os.fspath(path)
        return self

    @classmethod
    def parse(cls, text, name="session"):
        """Returns the session in the text of a .knead file; `name` stands in messages, and stamps are relative to it."""
        self = cls()._take(_knead.parse_session(str(text), os.fspath(name)))
        self.path = os.fspath(name)
        return self

    @property
    def parameters(self):
        """The values of the parameters by name, a new dict."""
        return {p.name: p.value for p in self._parameters}

    @property
    def bounds(self):
        """The bounds of the parameters by name: tuples (least, greatest), with None where there is no bound."""
        return {p.name: (p.least, p.greatest) for p in self._parameters}

    @property
    def walls(self):
        """The walls, as dicts, in a new list."""
        header = _knead.Session([], "")
        header.walls = self._walls
        return json.loads(header.text()).get("walls", [])

    def __call__(self, **values):
        """Returns the session with these values of its parameters.

        Raises InvalidInput for a name that is none of its parameters, a value beyond its bounds, and a stroke that cannot
        use the value.
        """
        numbers = {name: _real(value) for name, value in values.items()}
        changed = Session()._take(self._native(walls=True).with_values(numbers))
        changed.path = self.path
        return changed

    def _stroke(self, value):
        return _stroke_with(value, self._parameters)

    def _take(self, native):
        self.mesh, self.note, self._parameters, self._walls = native.mesh, native.note, native.parameters, native.walls
        self._strokes = [_wrap(s) for s in native.strokes]
        return self

    def text(self):
        """Returns the text of a .knead file; parse() gives an equal session."""
        return self._native(walls=True).text()

    def write(self, path):
        """Writes a .knead file, whole or not at all. Raises FileError."""
        self._native(walls=True).write(os.fspath(path))

    def resolve(self, vertices, faces=None, *, threads=0):
        """Returns the session as one that reads no surface: a flow for any points.

        Raises InvalidInput for a stroke that this shape cannot take.
        """
        strokes, _ = _knead.resolve(vertices, faces_for(vertices, faces), self._native(), threads)
        resolved = Session(note=self.note)
        resolved._strokes = [_wrap(s) for s in strokes]
        return resolved

    def jvp(self, points, direction, *, relative_tolerance=1e-8, threads=0, diagonal=None, progress=None):
        """Returns the deformed points, and how they move per unit of a direction in the space of the parameters.

        points: array-like (n, 3). direction: a dict of parameters and numbers (0 for those that it lacks), or a sequence
            of a number for each parameter, in their order.
        relative_tolerance: error of each segment, of the places relative to `diagonal` (by default that of the points'
            box), of the derivatives relative to themselves. progress: as for knead.deform.

        Returns two arrays (n, 3) of float64, or None if `progress` returned False. The session must read no surface.
        Raises InvalidInput for a parameter that chooses a whole number, or is in a mask or a grid.
        """
        request = derivative_request(relative_tolerance, threads, diagonal)
        return _knead.jvp(self._native(), points, self._direction(direction), request, progress)

    def vjp(self, points, gradient, *, of_points=False, relative_tolerance=1e-8, threads=0, diagonal=None, progress=None):
        """Returns the derivatives with respect to the parameters of a number that depends on the deformed points.

        points: array-like (n, 3), undeformed. gradient: array-like (n, 3): the derivatives of the number with respect to
            the deformed points. of_points: also return the derivatives with respect to the undeformed points. The other
            keywords are those of jvp().

        Returns a dict of a number for each parameter; with `of_points` an array (n, 3) of float64 and this dict. None
        if `progress` returned False. Raises as jvp(). The cost does not depend on the number of parameters.
        """
        request = derivative_request(relative_tolerance, threads, diagonal)
        found = _knead.vjp(self._native(), points, gradient, request, progress)
        if found is None:
            return None
        parameters = dict(zip(self.parameters, found[1]))
        return (found[0], parameters) if of_points else parameters

    def _direction(self, direction):
        if not isinstance(direction, collections.abc.Mapping):
            return [_real(number) for number in direction]
        unknown = [name for name in direction if name not in self.parameters]
        if unknown:
            raise _knead.InvalidInput(f'no parameter "{unknown[0]}"; the session has {", ".join(self.parameters) or "none"}')
        return [_real(direction.get(name, 0)) for name in self.parameters]

    def _native(self, walls=False):
        if self._walls and not walls:
            raise _knead.InvalidInput("the session has walls, which only knead.deform takes, for a mesh with patches")
        native = _knead.Session([s._native for s in self._strokes], self.path or "", self._parameters)
        native.mesh = self.mesh
        native.note = self.note
        native.walls = self._walls
        return native

    def __len__(self):
        return len(self._strokes)

    def __getitem__(self, index):
        if not isinstance(index, slice):
            return self._strokes[index]
        part = Session(self._strokes[index], self.mesh, self.note)
        part.path, part._parameters, part._walls = self.path, self._parameters, self._walls
        return part

    def __setitem__(self, index, value):
        self._strokes[index] = [self._stroke(s) for s in value] if isinstance(index, slice) else self._stroke(value)

    def __delitem__(self, index):
        del self._strokes[index]

    def insert(self, index, value):
        self._strokes.insert(index, self._stroke(value))

    def __getstate__(self):
        if not self._parameters and not self._walls:
            return self.__dict__
        return {**self.__dict__, "_parameters": [], "_walls": [], "_strokes": [], "_text": self.text()}

    def __setstate__(self, state):
        text = state.pop("_text", None)
        self.__dict__.update(state)
        if text is not None:
            self._take(_knead.parse_session(text, self.path or "session"))

    def __eq__(self, other):
        if not isinstance(other, Session):
            return NotImplemented
        return self.text() == other.text()

    __hash__ = None

    def _repr_png_(self):
        """Draws the tools on the shape that a session's file names; None for others."""
        from ._deform import picture
        from ._shapes import read

        if not (self.mesh and self.path):
            return None
        try:
            return picture(read(os.path.join(os.path.dirname(self.path), self.mesh)), self)
        except (_knead.FileError, _knead.InvalidInput):
            return None

    def __repr__(self):
        given = ("mesh", self.mesh), ("note", self.note), ("parameters", self.parameters or None), ("walls", self.walls or None)
        rest = "".join(f", {k}={v!r}" for k, v in given if v is not None)
        return f"knead.Session({self._strokes!r}{rest})"


def native_session(session):
    """Returns the native session of a Session, a stroke, or an iterable of strokes."""
    return (session if isinstance(session, Session) else Session(session))._native()
