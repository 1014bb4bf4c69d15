# SPDX-License-Identifier: GPL-3.0-or-later
"""Coordinates and faces of an object's mesh as arrays."""

import hashlib

import numpy as np

BASE = "knead_base"


class Refusal(Exception):
    """One sentence for the user: why it cannot be done, and what to do."""


def target(obj):
    """Returns what edits go to: the data of the active shape key, else the vertices of the mesh."""
    key = obj.active_shape_key
    return obj.data.vertices if key is None else key.data


def key_name(obj):
    """Returns the name of the active shape key; empty without one."""
    key = obj.active_shape_key
    return "" if key is None else key.name


def read(obj):
    """Returns the coordinates that edits go to: (n, 3) float32."""
    coordinates = np.empty(3 * len(obj.data.vertices), np.float32)
    target(obj).foreach_get("co", coordinates)
    return coordinates.reshape(-1, 3)


def read_rest(obj):
    """Returns the coordinates without shape keys: (n, 3) float32."""
    coordinates = np.empty(3 * len(obj.data.vertices), np.float32)
    keys = obj.data.shape_keys
    (obj.data.vertices if keys is None else keys.reference_key.data).foreach_get("co", coordinates)
    return coordinates.reshape(-1, 3)


def write(obj, coordinates):
    """Writes (n, 3) float32 where read() reads. The first shape key also gives the vertices their places."""
    flat = np.ascontiguousarray(coordinates, np.float32).ravel()
    target(obj).foreach_set("co", flat)
    keys = obj.data.shape_keys
    if keys is not None and obj.active_shape_key == keys.reference_key:
        obj.data.vertices.foreach_set("co", flat)
    obj.data.update()
    obj.data.update_tag()


def add_key(obj, name):
    """Adds a shape key with the mesh's own positions, makes it active and shows it; and the basis where there is none."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name=name, from_mix=False)
    key.value = 1.0
    obj.active_shape_key_index = len(obj.data.shape_keys.key_blocks) - 1
    return key


def faces(mesh):
    """Returns triangles as (m, 3) int32, or the polygons as a list of arrays."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    totals = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    if len(totals) and (totals == 3).all() and (np.diff(starts) == 3).all():
        return corners.reshape(-1, 3)
    return [corners[s : s + n] for s, n in zip(starts, totals)]


def read_base(mesh):
    """Returns the base positions (n, 3) float32, or None where there are none for these vertices."""
    attribute = mesh.attributes.get(BASE)
    if attribute is None or attribute.domain != "POINT" or len(attribute.data) != len(mesh.vertices):
        return None
    coordinates = np.empty(3 * len(mesh.vertices), np.float32)
    attribute.data.foreach_get("vector", coordinates)
    return coordinates.reshape(-1, 3)


def write_base(mesh, coordinates):
    attribute = mesh.attributes.get(BASE)
    if attribute is None:
        attribute = mesh.attributes.new(BASE, "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", np.ascontiguousarray(coordinates, np.float32).ravel())


def remove_base(mesh):
    attribute = mesh.attributes.get(BASE)
    if attribute is not None:
        mesh.attributes.remove(attribute)


def fingerprint(coordinates):
    """Returns a short text that differs where a bit of the coordinates does."""
    return hashlib.blake2b(np.ascontiguousarray(coordinates, np.float32), digest_size=16).hexdigest()


class Frame:
    """The space of a session beside the object's own: a 4x4 matrix, by rows; None is the object's own space."""

    def __init__(self, matrix=None):
        self.matrix = None if matrix is None else np.array(matrix, np.float64)
        if self.matrix is not None:
            if abs(np.linalg.det(self.matrix[:3, :3])) < 1e-30:
                raise ValueError("The object has a scale of zero; apply or change its scale")
            self.inverse = np.linalg.inv(self.matrix)

    def enter(self, coordinates):
        """Takes coordinates of the object to the space of the session, in double."""
        coordinates = np.asarray(coordinates, np.float64)
        if self.matrix is None:
            return coordinates
        return coordinates @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def leave(self, moved, entered, original):
        """Takes moved coordinates back, as float32. Those that did not move keep the bits of `original`."""
        if self.matrix is None:
            return moved.astype(np.float32)
        back = (moved @ self.inverse[:3, :3].T + self.inverse[:3, 3]).astype(np.float32)
        still = (moved == entered).all(axis=1)
        back[still] = original[still]
        return back
