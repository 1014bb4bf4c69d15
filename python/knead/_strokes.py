"""Strokes: one class for each tool, made from the library's description of the tools."""

import inspect
import json

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


def _to_json(name, keys):
    try:
        return json.dumps(keys, default=_plain, allow_nan=False)
    except ValueError:
        for key, value in keys.items():
            try:
                json.dumps(value, default=_plain, allow_nan=False)
            except ValueError:
                raise InvalidInput(f'{name}: "{key}" has a number that is not finite') from None
        raise


class Stroke:
    """One stroke of a session; a value that does not change. Its keys are attributes."""

    __slots__ = ("_native", "_values")
    tool = ""
    _is_event = False
    _described = ()

    def __init__(self, **keys):
        own = {key: value for key, value in keys.items() if value is not None}
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
        return _wrap(type(self)(**{**self._keys(), **keys})._native.with_remesh(self._native.remesh()))

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
        if key in values:
            return values[key]
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
        return f"knead.{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self._keys().items())})"

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
    if isinstance(keys, Stroke):
        return keys
    if not isinstance(keys, dict):
        raise TypeError(f"a stroke is made from a dict, not from a {type(keys).__name__}")
    return _wrap(_knead.Stroke(_to_json("stroke", keys), "stroke"))


# Of every tool: name, whether it is required, help, type.
_COMMON = (
    ("name", False, "text for people", "str"),
    ("off", False, "True: the stroke is skipped", "bool"),
    ("strength", False, "how much of the stroke is applied, 0 to 1.5", "float"),
    ("duration", False, "how long it takes beside the other strokes of an animation, above 0", "float"),
)


def _make_class(tool, is_event, keys):
    keys = (*keys, *_COMMON)
    doc = [f"A stroke of the tool {tool}. The keys, as in a session file (lengths in the shape's units, angles in degrees):", ""]
    for key, required, text, kind in keys:
        doc.append(f"    {key}: {kind}" + (", required" if required else "") + (f"; {text}" if text else ""))
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
