"""The programs that open files: what they read, and what they say about it."""
import os
import re
import shutil
import subprocess

from opened_elsewhere import shapes

HERE = os.path.dirname(os.path.abspath(__file__))
READS = {"assimp": ("ply", "obj", "glb", "stl", "off"), "openmesh": ("ply", "obj", "stl", "off"),
         "blender": ("ply", "obj", "glb", "stl"), "numpy": ("xyz",)}
PACKAGES = "apt install g++ libassimp-dev libopenmesh-dev blender python3-numpy python3-scipy"
TIMEOUT_S = 300


def build(folder):
    """Compiles the readers; returns what is wanting, a line."""
    for name, library in (("assimp", "assimp"), ("openmesh", "OpenMeshCore")):
        command = ["g++", "-std=c++20", "-O1", "-w", os.path.join(HERE, name + "_dump.cpp"), "-o",
                   os.path.join(folder, name + "_dump"), "-l" + library]
        if not shutil.which("g++") or subprocess.run(command, stderr=subprocess.DEVNULL).returncode:
            return f"{name} does not build; {PACKAGES}"
    return "" if shutil.which("blender") else f"blender is not there; {PACKAGES}"


def command_of(program, folder, shape, dump):
    if program == "blender":
        return ["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python",
                os.path.join(HERE, "blender_dump.py"), "--", shape, dump]
    return [os.path.join(folder, program + "_dump"), shape, dump]


def read(program, folder, shape):
    """The shape or None, and the lines that the program wrote and that complain."""
    if program == "numpy":
        return shapes.read_points(shape), []
    dump = os.path.join(folder, "dump")
    if os.path.exists(dump):
        os.remove(dump)
    done = subprocess.run(command_of(program, folder, shape, dump), capture_output=True, text=True, errors="replace",
                          timeout=TIMEOUT_S, cwd=folder)
    lines = [line.strip() for line in (done.stdout + done.stderr).split("\n") if line.strip()]
    if program == "blender":
        lines = [line for line in lines if re.search("warn|error|invalid|fail", line, re.IGNORECASE)]
    if done.returncode or not os.path.exists(dump):
        return None, lines or [f"exit code {done.returncode}"]
    return shapes.read_dump(dump), lines
