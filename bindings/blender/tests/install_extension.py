"""Validates and installs an extension as `blender --command extension` does, in Blender as a module:

install_extension.py EXTENSION.zip
"""

import os
import subprocess
import sys

import bpy

_zip = os.path.abspath(sys.argv[-1])
_tool = os.path.join(bpy.utils.system_resource("SCRIPTS"), "addons_core", "bl_pkg", "cli", "blender_ext.py")
subprocess.run([sys.executable, _tool, "validate", _zip], check=True)
bpy.ops.preferences.addon_enable(module="bl_pkg")
assert bpy.ops.extensions.package_install_files(filepath=_zip, repo="user_default", enable_on_install=True) == {"FINISHED"}
assert "bl_ext.user_default.knead" in bpy.context.preferences.addons
module = sys.modules["bl_ext.user_default.knead.native"].knead
assert module.__file__.startswith(os.environ["BLENDER_USER_EXTENSIONS"]), module.__file__
print("installed", module.__file__)
