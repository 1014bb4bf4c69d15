"""Knead in Blender: deforms meshes by divergence-free vector fields. The user's page is docs/blender.md."""

bl_info = {
    "name": "Knead",
    "description": "Applies sessions of strokes that keep the volume",
    "author": "The Knead authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Knead",
    "category": "Sculpting",
}

from . import bake, check, operators, panel, state

_MODULES = (state, operators, check, bake, panel)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
