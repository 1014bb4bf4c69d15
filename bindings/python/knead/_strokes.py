"""Strokes: one class for each tool, made from the library's description of the tools."""

import base64
import inspect
import json
import keyword
import textwrap

import numpy as np

from . import _knead
from ._knead import InvalidInput


def _plain(value):
    """Returns what JSON can hold in the place of arrays, numbers of numpy, and paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "__fspath__"):
        return value.__fspath__()
    if hasattr(value, "__iter__"):
        return list(value)
    raise TypeError(f"a stroke cannot hold a {type(value).__name__}")


def _ranges(vertices):
    """Returns numbers of vertices, or a mask of them, as sorted ranges [first, last]; anything else as it is."""
    if isinstance(vertices, (set, frozenset, range)) or (
        isinstance(vertices, (list, tuple)) and vertices and all(isinstance(v, (bool, np.bool_)) for v in vertices)
    ):
        vertices = np.array(list(vertices))
    if not hasattr(vertices, "__array__"):
        return vertices
    vertices = np.asarray(vertices)
    if vertices.ndim != 1 or vertices.dtype.kind not in "biu":
        return vertices.tolist()
    numbers = np.flatnonzero(vertices) if vertices.dtype.kind == "b" else np.unique(vertices)
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return [[int(run[0]), int(run[-1])] for run in runs if len(run)]


def _regions(regions):
    """Returns regions or parts, whose "vertices" may be arrays, as lists of JSON objects."""
    if not isinstance(regions, (list, tuple)):
        return regions
    return [
        {**region, "vertices": _ranges(region["vertices"])} if isinstance(region, dict) and "vertices" in region else region
        for region in regions
    ]


def _coefficients(vectors):
    """Returns an array of vectors as base64 of float64, as a session file holds them; text as it is."""
    if isinstance(vectors, str):
        return vectors
    return base64.b64encode(np.ascontiguousarray(vectors, "<f8").tobytes()).decode()


def _with_counts(keys):
    """Returns the keys of a lattice, whose displacements may be an array (nx, ny, nz, 3): that also gives the counts."""
    try:
        given = np.asarray(keys.get("displacements"), dtype=object)
    except ValueError:
        return keys
    if given.ndim != 4:
        return keys
    return {"counts": list(given.shape[:3]), **keys, "displacements": given.reshape(-1, given.shape[3]).tolist()}


# The keys of a tool that may be arrays where a session file has something shorter.
_SHORTER = {
    "pose": {"parts": _regions, "stiffness": _regions},
    "grid": {"coefficients": _coefficients, "end_coefficients": _coefficients, "growth": _coefficients},
}


def _to_json(name, keys):
    shorter = _SHORTER.get(keys["tool"], {}) if isinstance(keys.get("tool"), str) else {}
    keys = {key: shorter[key](value) if key in shorter else value for key, value in keys.items()}
    if keys.get("tool") == "lattice":
        keys = _with_counts(keys)
    try:
        return json.dumps(keys, default=_plain, allow_nan=False)
    except ValueError:
        for key, value in keys.items():
            try:
                json.dumps(value, default=_plain, allow_nan=False)
            except ValueError:
                raise InvalidInput(f'{name}: "{key}" has a number that is not finite') from None
        raise


# A key that is a word of Python's own, as "from", has an underscore after it there.
def _python_name(key):
    return key + "_" if keyword.iskeyword(key) else key


def _json_name(name):
    return name[:-1] if name.endswith("_") and keyword.iskeyword(name[:-1]) else name


class Stroke:
    """One stroke of a session; a value that does not change. Its keys are attributes."""

    __slots__ = ("_native", "_values")
    tool = ""
    _is_event = False
    _described = ()

    def __init__(self, **keys):
        own = {_json_name(key): value for key, value in keys.items() if value is not None}
        line = {self.tool: own or None} if self._is_event else {"tool": self.tool, **own}
        native = _knead.Stroke(_to_json(type(self).__name__, line), type(self).__name__)
        object.__setattr__(self, "_native", native)

    def to_dict(self):
        """Returns the stroke as the JSON object of its line in a session file; default values are left out."""
        return json.loads(self._native.line())

    @classmethod
    def describe(cls):
        """Returns a dict for each key of the tool: name, required, help and type, as in the stubs."""
        return [dict(zip(("name", "required", "help", "type"), key)) for key in cls._described]

    def replace(self, **keys):
        """Returns a stroke with other values of some keys. None takes a key away."""
        return _wrap(type(self)(**{**self._keys(), **{_json_name(k): v for k, v in keys.items()}})._native.with_remesh(self._native.remesh()))

    def _keys(self):
        keys = self.to_dict()
        return (keys[self.tool] or {}) if self._is_event else {k: v for k, v in keys.items() if k != "tool"}

    def __getattr__(self, key):
        if key.startswith("_"):
            raise AttributeError(key)
        try:
            values = object.__getattribute__(self, "_values")
        except AttributeError:
            values = json.loads(self._native.values())
            object.__setattr__(self, "_values", values)
        if _json_name(key) in values:
            return values[_json_name(key)]
        if key in type(self)._names:
            return None
        raise AttributeError(f"a stroke of the tool {self.tool} has no key {key!r}")

    def __setattr__(self, key, value):
        raise AttributeError(f"a stroke does not change; use replace({key}=...)")

    def __dir__(self):
        return [*super().__dir__(), *type(self)._names]

    def __eq__(self, other):
        return self._native == other._native if isinstance(other, Stroke) else NotImplemented

    def __hash__(self):
        return hash(self._native.line())

    def __repr__(self):
        return f"knead.{type(self).__name__}({', '.join(f'{_python_name(k)}={v!r}' for k, v in self._keys().items())})"

    def __reduce__(self):
        return _restore, (self._native.line(), self._native.remesh())


def _wrap(native):
    """Returns the stroke of the right class around a native one."""
    self = object.__new__(_classes[native.tool])
    object.__setattr__(self, "_native", native)
    return self


def _restore(line, remesh):
    return _wrap(_knead.Stroke(line, "stroke").with_remesh(remesh))


def stroke(keys):
    """Returns the stroke that a JSON object describes, as a line of a session file: {"tool": "bend", ...}.

    Raises InvalidInput for anything that is not exactly a stroke.
    """
    return _stroke_with(keys, [])


def _stroke_with(keys, parameters):
    """Does the same where the stroke may name these native parameters."""
    if isinstance(keys, Stroke):
        return keys
    if not isinstance(keys, dict):
        raise TypeError(f"a stroke is made from a dict, not from a {type(keys).__name__}")
    return _wrap(_knead.Stroke(_to_json("stroke", keys), "stroke", parameters))


# Of every tool: name, whether it is required, help, type.
_COMMON = (
    ("name", False, "text for people", "str"),
    ("off", False, "True: the stroke is skipped", "bool"),
    ("strength", False, "how much of the stroke is applied, 0 to 1.5", "float"),
    ("duration", False, "how long it takes beside the other strokes of an animation, above 0", "float"),
    ("new_entry", False, "whether the stroke begins an entry of Studio's history; by default the strokes tell", "bool"),
)
_MIRROR = (
    "mirror",
    False,
    'planes in which the stroke is mirrored, and its images act at the same time: coordinate planes as "x" or "xz"; or '
    '{"normal": (3,), "point": (3,)}, or a list of up to three of these at right angles',
    "str | dict | list",
)


# What the docstring of a tool says besides its keys.
_DETAILS = {
    "pose": """
    Parts and pins go to their places, and the body between follows as nearly rigidly as a motion that keeps the volume
    can. Each item of `parts` is a dict: a part, or a pin.

        vertices: the part's vertices when the stroke begins: an integer array (k,), a boolean mask (n,), or a list of
            numbers and ranges [first, last]; or points: an array (k, 3) of coordinates in their place
        hold: True: the part stays; or it moves by rotate (an axis (3,)), center (3,) and angle_deg (degrees), by
            translate (3,), or by both at once, as a screw

        pin: the number of a vertex; or pin_point: a point (3,)
        hold: True: the pin stays; or to: the place (3,) that it goes to; or path: places (k, 3), one after the other
        size: radius of the patch that moves rigidly with the pin, a fraction of the shape's diagonal in (0, 0.5], 0.025
        turn: None: the patch keeps its direction; {"axis": (3,), "angle_deg": degrees}: it turns by that; left out: it
            turns as the body takes it

    Each item of `stiffness` is a dict of vertices, as above, and value: how stiff they are, in [0.01, 100]; elsewhere 1.
    detail is in [0.01, 0.5], or 0: from the thickness of what moves; tolerance in [0.0001, 0.5]; exact: True takes parts and pins to their places exactly, by a last stroke of pins.

    It reads the surface, so deform() needs `faces`. Also raises InvalidInput for a vertex in two parts, more than 1000
    pins, and parts of which none moves; deform() does for vertices that the shape does not have. Nothing has moved then.
    A pose that would cross or spoil the shape comes as far as it is sound, and a UserWarning says how far.

        tip = int(np.argmax(vertices[:, 1]))
        wrist = vertices[:, 1] < 0.1
        pose = knead.Pose(parts=[{"vertices": wrist, "hold": True}, {"pin": tip, "to": vertices[tip] + [0.1, 0, 0]}])
        moved = knead.deform(vertices, pose, faces)
""",
    "grid": """
    The flow of v = curl A over one unit of time. A is a cubic B-spline with the vectors `coefficients` at the nodes
    origin + spacing (i, j, k), of which there are counts = (nx, ny, nz). More than two cells beyond the nodes nothing
    moves. A pose becomes such strokes: Session([pose]).resolve(vertices, faces).

        coefficients: an array of the nodes' vectors, x the fastest: (nz, ny, nx, 3) or (nx ny nz, 3); or base64 of them
            as little-endian float64, as session files have it and as the attribute returns it:
            np.frombuffer(base64.b64decode(grid.coefficients)).reshape(*grid.counts[::-1], 3)
        end_coefficients: the same at the stroke's end, if they change linearly in time
        growth: an array of one number for each node, or base64 of it: p of v = curl A + grad p, which changes volumes
""",
    "curve": """
    A line through the shape becomes another line, or an arc, and the shape follows; volume is kept exactly, or with
    keep="thickness" the distances from the line. Without `from_` the line is the longest axis of the shape's box, so
    deform() reads the vertices.

        ring = knead.deform(vertices, knead.Curve(angle_deg=270, axis=[0, 1, 0]), faces)
        hose = knead.deform(vertices, knead.Curve(to=path), faces)
        grip = knead.deform(vertices, knead.Curve(from_=[a, b], thicker_by=2, keep="length"), faces)
""",
    "lattice": """
    A box of control points whose displacements move what is in the box. `displacements` may be an array
    (nx, ny, nz, 3), which also gives the counts; the attribute is a list (nx ny nz, 3). `axes`: an array (3, 3), of
    which a row is the direction of an edge. mode="volume" (the default) and "rigid" read the surface, so deform() needs
    `faces`; "spline" is an exact map; Flow.vjp() has its derivatives. `file`: PyGeM's parameters (.prm) in the
    place of all numbers.

        box = knead.Lattice(origin=[-1, -1, -1], lengths=[2, 2, 2], displacements=np.zeros((5, 3, 3, 3)))
        bent = knead.deform(vertices, box.replace(displacements=bend(knead.lattice_points(box))), faces)

    Raises InvalidInput in deform() for displacements that fold the box, and for a shape that reaches through a face of
    the box at which the two outer layers of control points do not rest.
""",
    "inflate": """
    The surface moves outwards, most along the path through `points`: by `depth` where it moves most, or so far that the
    shape gains exactly `volume`; inwards if that is negative. Give one of the two. Nothing farther than `radius` from the
    path moves at all. It reads the surface, so deform() needs `faces`.

        bigger = knead.deform(vertices, knead.Inflate(points=[place], radius=0.2, depth=0.05), faces)
""",
    "print": """
    Text, a picture or the lowest face of a mesh is pressed into the surface, or with a negative `depth` raised; the volume goes
    far around. It reads the surface, so deform() and remesh() need `faces`; remesh() also shows it on coarse faces.

        named = knead.remesh(vertices, faces, knead.Print(text="No. 7", height=8, depth=0.6))
""",
}


def _make_class(tool, is_event, keys):
    keys = tuple((_python_name(key), *rest) for key, *rest in keys)
    keys = (*keys, *_COMMON) if is_event else (*keys, *_COMMON, _MIRROR)
    doc = [f"A stroke of the tool {tool}. The keys, as in a session file (lengths in the shape's units, angles in degrees):", ""]
    for key, required, text, kind in keys:
        doc.append(f"    {key}: {kind}" + (", required" if required else "") + (f"; {text}" if text else ""))
    doc += textwrap.dedent(_DETAILS.get(tool, "")).rstrip().split("\n")
    doc += ["", "Raises InvalidInput for a missing or unknown key, or a value that the tool cannot use."]
    order = sorted(keys, key=lambda k: not k[1])
    parameters = [
        inspect.Parameter(k, inspect.Parameter.KEYWORD_ONLY, default=inspect.Parameter.empty if required else None)
        for k, required, *_ in order
    ]
    return type(
        tool.capitalize(),
        (Stroke,),
        {
            "__slots__": (),
            "__module__": "knead",
            "__doc__": "\n".join(doc),
            "__signature__": inspect.Signature(parameters),
            "tool": tool,
            "_is_event": is_event,
            "_described": keys,
            "_names": frozenset(k for k, *_ in keys),
        },
    )


_classes = {tool: _make_class(tool, is_event, keys) for tool, is_event, keys in _knead.tools()}
