# SPDX-License-Identifier: GPL-3.0-or-later
"""From the pixels of a 3D view to the space of a session, and back."""

import numpy as np
from bpy_extras import view3d_utils


def to_session(obj, frame):
    """Returns the matrix from the world to the space of the session."""
    matrix = np.linalg.inv(np.array(obj.matrix_world, np.float64))
    return matrix if frame.matrix is None else frame.matrix @ matrix


def _point(matrix, p):
    return matrix[:3, :3] @ np.asarray(p, np.float64) + matrix[:3, 3]


class View:
    """One region of a 3D view, and an object in the space of its session."""

    def __init__(self, region, data, obj, frame):
        self.region, self.data, self.obj = region, data, obj
        self.matrix = to_session(obj, frame)
        self.inverse = np.linalg.inv(self.matrix)

    def world_ray(self, pixel):
        origin = view3d_utils.region_2d_to_origin_3d(self.region, self.data, pixel, clamp=1e5)
        return np.array(origin, np.float64), np.array(view3d_utils.region_2d_to_vector_3d(self.region, self.data, pixel))

    def ray(self, pixel):
        """Returns origin and direction of the ray through a pixel."""
        origin, direction = self.world_ray(pixel)
        return _point(self.matrix, origin), self.matrix[:3, :3] @ direction

    def on_plane(self, pixel, point):
        """Returns where the pixel's ray meets the plane through a point that faces the viewer."""
        at = _point(self.inverse, point)
        normal = np.array(self.data.view_rotation.to_matrix().col[2], np.float64)
        origin, direction = self.world_ray(pixel)
        return _point(self.matrix, origin + direction * (np.dot(at - origin, normal) / np.dot(direction, normal)))

    def direction(self, axis):
        """Returns the view's right (0), up (1) or backward (2) direction as a unit vector."""
        vector = self.matrix[:3, :3] @ np.array(self.data.view_rotation.to_matrix().col[axis], np.float64)
        return vector / np.linalg.norm(vector)

    def pixels(self, points):
        """Returns the pixels of points: (n, 2); NaN behind the eye."""
        matrix = np.array(self.data.perspective_matrix, np.float64) @ self.inverse
        points = np.asarray(points, np.float64).reshape(-1, 3)
        out = points @ matrix[:, :3].T + matrix[:, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            flat = np.where(out[:, 3:] > 0, out[:, :2] / out[:, 3:], np.nan)
        return (flat * 0.5 + 0.5) * [self.region.width, self.region.height]

    def pixel_size(self, point):
        """Returns the length that one pixel covers at a point."""
        right = self.direction(0)
        step = self.pixels([point, np.asarray(point) + right])
        length = float(np.linalg.norm(step[1] - step[0]))
        return 1 / length if length > 0 else 1.0
