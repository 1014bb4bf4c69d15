# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a stroke as properties of an operator, from the library's description of the tools."""

import json
import re

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from .native import knead

_COMMON = {"name", "off", "duration", "mirror", "new_entry"}
_TEXT = {"samples", "path", "pose", "parts", "stiffness"}  # as JSON; too long for a panel


def _property(key):
    name, help_text, kind = key["name"].replace("_", " ").capitalize(), key["help"], key["type"]
    if key["name"] == "strength":
        return FloatProperty(name=name, description=help_text, default=1, min=0, max=1.5)
    if kind.startswith("float"):
        return FloatProperty(name=name, description=help_text, precision=4)
    if kind == "bool":
        return BoolProperty(name=name, description=help_text)
    if kind.startswith("int") and "Literal" in kind:
        return StringProperty(name=name, description=help_text)
    if kind.startswith("int"):
        return IntProperty(name=name, description=help_text)
    if kind == "Vector":
        return FloatVectorProperty(name=name, description=help_text, size=3, precision=4)
    if kind.startswith("Literal"):
        words = re.findall(r"'([^']*)'", kind)
        return EnumProperty(name=name, description=help_text, items=[(word, word.capitalize(), "") for word in words])
    return StringProperty(name=name, description=help_text, options={"HIDDEN"} if key["name"] in _TEXT else set())


def _described(cls):
    return [key for key in cls.describe() if key["name"] not in _COMMON]


def properties(cls):
    """Returns annotations for the keys of a class of strokes."""
    return {key["name"]: _property(key) for key in _described(cls)}


def _is_text(cls, name):
    kind = next(key["type"] for key in _described(cls) if key["name"] == name)
    return not (kind.startswith(("float", "int", "Literal")) or kind in ("bool", "Vector", "str"))


def _is_number_or_word(cls, name):
    kind = next(key["type"] for key in _described(cls) if key["name"] == name)
    return kind.startswith("int") and "Literal" in kind


def _as_property(cls, name, value):
    if _is_number_or_word(cls, name):
        return str(value)
    return json.dumps(value) if _is_text(cls, name) else value


def _as_key(cls, name, value):
    if _is_number_or_word(cls, name):
        return int(value) if value.isdigit() else value
    if _is_text(cls, name):
        return json.loads(value)
    return list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _same(a, b):
    """Returns whether a property, which holds float32, is what a key was."""
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return np.array_equal(np.asarray(a, np.float32), np.asarray(b, np.float32))


def write(operator, cls, strokes):
    """Gives the properties the keys of strokes that a gesture made, and takes away those of an earlier use."""
    for key in _described(cls):
        operator.properties.property_unset(key["name"])
    operator.made = json.dumps([stroke.to_dict() for stroke in strokes])
    for name, value in strokes[0].to_dict().items():
        if name in cls.__signature__.parameters and name not in _COMMON:
            setattr(operator, name, _as_property(cls, name, value))


def shown(operator, cls):
    """Returns the names of the properties that a panel shows."""
    made = json.loads(operator.made or "[]")
    held = set(made[0]) if made else {key["name"] for key in _described(cls) if key["required"]}
    return [key["name"] for key in _described(cls) if key["name"] in held | {"strength"} and key["name"] not in _TEXT]


def read(operator, cls):
    """Returns the strokes that the properties describe: those of the gesture, with what was changed since."""
    names = [key["name"] for key in _described(cls) if operator.properties.is_property_set(key["name"])]
    values = {name: _as_key(cls, name, getattr(operator, name)) for name in names}
    made = json.loads(operator.made or "[]")
    if not made:
        return [cls(**values)]
    changed = {name: value for name, value in values.items() if not _same(value, made[0].get(name, _missing(name)))}
    return [knead.stroke({**each, **_changed(each, changed, made)}) for each in made]


def _missing(name):
    return 1.0 if name == "strength" else "missing"


def _changed(each, changed, made):
    """Returns the changed keys of one of several strokes: lengths that differ between them keep their ratio."""
    result = {}
    for name, value in changed.items():
        first, own = made[0].get(name), each.get(name)
        differs = isinstance(first, float) and first != 0 and own != first and own is not None
        result[name] = value * own / first if differs else each[name] if name in _TEXT and len(made) > 1 else value
    return result
