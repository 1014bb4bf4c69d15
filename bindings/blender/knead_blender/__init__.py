# SPDX-License-Identifier: GPL-3.0-or-later
"""Knead in Blender: deforms meshes by divergence-free vector fields. The user's page is docs/blender.md."""

bl_info = {
    "name": "Knead",
    "description": "Tools and sessions of strokes that keep the volume",
    "author": "The Knead authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Tool Bar, and Sidebar > Knead",
    "category": "Sculpting",
}

from . import bake, check, correctives, operators, panel, poses, settings, stamps, state, tools, workspace

_MODULES = (state, settings, stamps, operators, poses, tools, check, correctives, bake, panel, workspace)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
