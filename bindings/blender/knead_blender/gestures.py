# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pointer does between press and release, as the strokes of a tool."""

import numpy as np

from . import poses, stamps, state
from .native import knead

_DEGREES_PER_PIXEL = 0.5
_PERCENT_PER_PIXEL = 0.4  # of the logarithm
_SNAP_DEGREES = 15
_SHORTEST_PIECE = 0.01  # of the radius
_SNAP_LENGTH = 0.1  # of the radius
_STAND_OFF = 0.02  # of the stamp's size: from the surface
_LEAST_PRESSURE = 0.05
_PRESSURE_STEPS = 16  # of a pen's radius
_LIVE_DETAIL = 0.12  # of a pose, while it is dragged
_POSE_PIECE = 0.02  # of the mesh's diagonal: the shortest piece of a pin's path
_PIN_SIZE = 0.025  # of the diagonal
_MOST_POINTS = 200  # of a part that has a mirror image
_MOST_RAYS = 400  # between two places of the pointer


class Pointer:
    """Where the pointer is, what is held and what was typed."""

    def __init__(self, pixel, ctrl=False, pressure=1.0, typed=None):
        self.pixel, self.ctrl, self.pressure, self.typed = np.asarray(pixel, float), ctrl, pressure, typed

    def snapped(self, value, step):
        if self.typed is not None:
            return self.typed
        return step * round(value / step) if self.ctrl else value


class Gesture:
    """A drag that began at a place of the surface. Lengths are in the space of the session."""

    def __init__(self, view, live, settings, pointer, hit):
        self.view, self.live, self.settings, self.start = view, live, settings, pointer
        self.point, self.normal = (np.array(v) for v in hit)
        self.radius = settings.radius * live.size
        self.inner = settings.inner_ratio * self.radius
        self.falloff = {} if settings.falloff == 4 else {"falloff": settings.falloff}
        self.begin()

    def begin(self):
        pass

    def end(self):
        pass

    def click(self):
        """What a press without a drag does."""

    def ring_at(self):
        """Returns where the rings are drawn, and their radii."""
        return self.point, self.normal, (self.radius, self.inner)

    def _drag(self, pointer):
        return pointer.pixel - self.start.pixel


class AlongPath(Gesture):
    """A place that goes with the pointer, in the plane that faces the viewer."""

    unit = ""

    def _start(self, place, piece):
        """Begins at a place of the space of the session. `piece`: the shortest piece of the path."""
        self.path, self._piece = [place], piece
        self._offset = place - self.view.on_plane(self.start.pixel, place)

    def move(self, pointer):
        place = self.view.on_plane(pointer.pixel, self.path[0]) + self._offset
        if pointer.typed is not None or pointer.ctrl:
            way = place - self.path[0]
            length = float(np.linalg.norm(way))
            unit = way / length if length > 0 else self.normal
            to = self.path[0] + unit * pointer.snapped(length, _SNAP_LENGTH * self.radius)
            self.path = self.path[:1] if (to == self.path[0]).all() else [self.path[0], to]
        elif np.linalg.norm(place - self.path[-1]) >= self._piece:
            self.path.append(place)

    def amount(self):
        return float(np.linalg.norm(self.path[-1] - self.path[0]))


class Pull(AlongPath):
    """A ball along the pointer's path, in the plane that faces the viewer."""

    cls = knead.Implicit

    def begin(self):
        thickness = self.live.surface.thickness(self.point, self.normal)
        deep = self.inner if thickness is None else min(self.inner, 0.5 * thickness)
        self._start(self.point - self.normal * deep, _SHORTEST_PIECE * self.radius)

    def strokes(self):
        return [self._stroke([p.tolist() for p in self.path])] if len(self.path) > 1 else []

    def _stroke(self, path):
        return knead.Implicit(path=path, inner=self.inner, outer=self.radius, **self.falloff)

    def ring_at(self):
        return self.point + self.path[-1] - self.path[0], self.normal, (self.radius, self.inner)


class Move(Pull):
    """The surface along the pointer's path, in the plane that faces the viewer."""

    brush = "move"

    def begin(self):
        self._start(self.point, _SHORTEST_PIECE * self.radius)

    def _stroke(self, path):
        return knead.brush(self.brush, path, radius=self.radius)

    def ring_at(self):
        return (*super().ring_at()[:2], (self.radius,))


class Snakehook(Move):
    """The same, with a pointed end."""

    brush = "snakehook"


class Paint(Gesture):
    """Dabs along the pointer's path. Ctrl does the contrary; a typed number is the height of a layer."""

    brush = "paint"
    cls = knead.Paint
    unit = ""

    def begin(self):
        self._last = self.start
        self._touches = [(self.point.tolist(), self.normal.tolist(), self.start.pressure)]
        self._amount = (-1 if self.start.ctrl else 1) * self._wanted()
        self._again()

    def _wanted(self):
        return self.settings.depth

    def _typed(self, number):
        return number / self.radius

    def _again(self):
        keys = knead.brush(self.brush, [self.point], radius=self.radius, amount=self._amount)
        how = {"falloff": "wide", "pinch": keys.pinch or 0.0, "surface": self.live.surface}
        self._paint = knead.PaintDrag(outer=self.radius, depth=keys.depth, **how)
        for touch in self._touches:
            self._touch(*touch)

    def _touch(self, point, normal, pressure):
        pressure = min(max(pressure, _LEAST_PRESSURE), 1.0)
        kind = self.settings.pressure
        outer = self.radius * np.ceil(_PRESSURE_STEPS * pressure) / _PRESSURE_STEPS if kind == "RADIUS" else None
        self._paint.touch(point, normal, outer=outer, pressure=pressure if kind == "DEPTH" else 1.0)

    def move(self, pointer):
        if pointer.typed not in (None, 0) and self._amount != self._typed(pointer.typed):
            self._amount = self._typed(pointer.typed)
            self._again()
        way = pointer.pixel - self._last.pixel
        fine = max(0.25 * self._paint.spacing / self.view.pixel_size(self.point), 0.5)
        rays = int(min(max(np.ceil(np.hypot(*way) / fine), 1), _MOST_RAYS))
        for i in range(1, rays + 1):
            t = i / rays
            hit = self.live.surface.hit(*self.view.ray(self._last.pixel + way * t))
            if hit is not None:
                pressure = self._last.pressure + (pointer.pressure - self._last.pressure) * t
                self._touches.append((*hit, pressure))
                self._touch(*self._touches[-1])
                self.point, self.normal = (np.array(v) for v in hit)
        self._last = pointer

    def end(self):
        self._paint.finish()

    def amount(self):
        return self._amount * self.radius

    def strokes(self):
        return self._paint.strokes

    def ring_at(self):
        return self.point, self.normal, (self.radius,)


class Crease(Paint):
    """A crease along the pointer's path, with Ctrl a ridge. A typed number is the strength."""

    brush = "crease"

    def _wanted(self):
        return self.settings.pinch

    def _typed(self, number):
        return number

    def amount(self):
        return self._amount


class Pinch(Crease):
    """Draws the surface together, with Ctrl apart."""

    brush = "pinch"


class Flatten(Crease):
    """Presses bumps and dents to a plane; Ctrl makes them stronger."""

    brush = "flatten"


class Turn(Gesture):
    """A turn by an amount in degrees."""

    unit = "°"
    value = 0.0

    def move(self, pointer):
        self.value = pointer.snapped(self.degrees(self._drag(pointer)), _SNAP_DEGREES)

    def amount(self):
        return self.value

    def strokes(self):
        return [] if self.value == 0 else [self.stroke()]


class Rotate(Turn):
    """A ball about the line towards the viewer: to the right is clockwise."""

    cls = knead.Rotate

    def degrees(self, drag):
        return -drag[0] * _DEGREES_PER_PIXEL

    def stroke(self):
        return knead.Rotate(
            center=self.point,
            axis=self.view.direction(2),
            angle_deg=self.value,
            inner=self.inner,
            outer=self.radius,
            **self.falloff,
        )


class Stretch(Turn):
    """A ball along the normal, in percent: right or up is longer."""

    cls = knead.Stretch
    unit = "%"

    def move(self, pointer):
        free = 100 * np.expm1((self._drag(pointer).sum()) * _PERCENT_PER_PIXEL / 100)
        self.value = max(float(pointer.snapped(free, 10)), -90.0)

    def stroke(self):
        return knead.Stretch(
            center=self.point,
            axis=self.normal,
            factor=1 + self.value / 100,
            inner=self.inner,
            outer=self.radius,
            **self.falloff,
        )


class OfPart(Turn):
    """Twist or bend of what lies beyond the place, away from the middle of the shape."""

    def begin(self):
        middle = self.live.surface.middle(*self.view.ray(self.start.pixel))
        self.point = np.array(middle)
        self.axis = self.view.direction(2)
        center = 0.5 * (self.live.entered.min(axis=0) + self.live.entered.max(axis=0))
        flat = self.point - center - self.axis * np.dot(self.point - center, self.axis)
        self._place(flat)
        tip = self.view.pixels([self.point, self.point - np.array(self.keys["normal"]) * 0.1 * self.radius])
        along = tip[1] - tip[0]
        length = np.hypot(*along)
        self._across = np.array([along[1], -along[0]]) / length if length > 0 else np.array([1.0, 0.0])

    def _place(self, flat):
        right, up = self.view.direction(0), self.view.direction(1)
        ways = sorted((right, -right, up, -up), key=lambda way: -np.dot(way, flat))
        if np.linalg.norm(flat) > 0:
            ways.insert(0, flat / np.linalg.norm(flat))
        if not self.settings.whole_part:
            self.keys = self.beyond(ways[1])
            return
        for i, way in enumerate(ways[:3]):
            try:
                self.keys = self.live.surface.part(self.point, way)
                return
            except knead.InvalidInput as error:
                if i == 0:
                    why = str(error)
        raise knead.InvalidInput(f"{why} (or switch off One Part)")

    def degrees(self, drag):
        return float(np.dot(drag, self._across)) * _DEGREES_PER_PIXEL

    def strokes(self):
        if self.value == 0:
            return []
        stroke = self.stroke()
        return [self.live.surface.with_safe_zone(stroke) if self.settings.widen_zone else stroke]

    def ring_at(self):
        keys = self.keys
        return np.array(keys["center"]), np.array(keys["normal"]), (keys.get("radius", self.radius),)


class Twist(OfPart):
    cls = knead.Twist

    def beyond(self, way):
        return {"center": self.point, "normal": -way, "inner": -0.5 * self.radius, "outer": 0.5 * self.radius}

    def stroke(self):
        rate = -self.value / (self.keys["outer"] - self.keys["inner"])
        axis = -np.array(self.keys["normal"])
        return knead.Twist(axis=axis, rate_deg=rate, **self.keys, **self.falloff)


class Bend(OfPart):
    """In the plane that faces the viewer: the part goes with the pointer."""

    cls = knead.Bend

    def beyond(self, way):
        return {"center": self.point, "normal": -way, "width": self.radius}

    def stroke(self):
        normal = np.array(self.keys["normal"])
        across = self.axis - normal * np.dot(normal, self.axis)
        return knead.Bend(
            axis=across / np.linalg.norm(across), angle_deg=-self.value, **self.keys, **self.falloff
        )


class Stamp(Gesture):
    """A closed mesh that is pressed in against the normal, as deep as the pointer goes."""

    cls = knead.Stamp
    unit = ""

    def begin(self):
        path, points = stamps.make(self.settings, self.view.obj)
        half = self.settings.stamp_size * self.radius
        x = self.view.direction(0)
        x = x - self.normal * np.dot(self.normal, x)
        if np.linalg.norm(x) < 1e-6:
            x = np.cross(self.normal, np.eye(3)[np.abs(self.normal).argmin()])
        x /= np.linalg.norm(x)
        frame = np.column_stack([x, np.cross(self.normal, x), self.normal])
        pose = frame * (half / (np.abs(points).max() or 1.0))
        self._reach = float((points @ pose.T @ -self.normal).max())
        self._keys = {"mesh": path, "pose": pose, "outer": 1.5 * half, "step": 1.5 * half / 25}
        self._stand = self._reach + _STAND_OFF * half
        self._depths = [0.0]
        self._pixel = self.view.pixel_size(self.point)

    def move(self, pointer):
        depth = pointer.snapped(float(np.hypot(*self._drag(pointer))) * self._pixel, _SNAP_LENGTH * self.radius)
        depth = max(depth, 0.0)
        while self._depths[-1] > depth:
            self._depths.pop()
        if depth - self._depths[-1] >= self._keys["step"] or pointer.typed is not None or pointer.ctrl:
            if pointer.typed is not None or pointer.ctrl:
                self._depths = [0.0]
            if depth > self._depths[-1]:
                self._depths.append(depth)

    def amount(self):
        return self._depths[-1]

    def strokes(self):
        heights = [self._stand, *(self._reach - depth for depth in self._depths[1:])]
        places = [self.point + self.normal * height for height in heights]
        return [knead.Stamp(path=[a, b], **self._keys, **self.falloff) for a, b in zip(places, places[1:])]

    def ring_at(self):
        return self.point, self.normal, (self._keys["outer"],)


class Pose(AlongPath):
    """A vertex along the pointer's path, in the plane that faces the viewer; what is pinned or masked stays.

    Coarse while it is dragged, and in full detail at its end. A click pins the vertex, or frees it.
    """

    cls = knead.Pose

    def begin(self):
        vertices = self.live.vertices
        self._obj = self.view.obj
        self._vertex = int(np.linalg.norm(vertices - self.point, axis=1).argmin())
        self._vertices = vertices
        self._start(vertices[self._vertex], _POSE_PIECE * self.live.size)
        self._detail = max(self.settings.pose_detail, _LIVE_DETAIL)

    def end(self):
        self._detail = self.settings.pose_detail

    def click(self):
        held = poses.pins(self._obj)
        poses.set_pins(self._obj, set(held) ^ {self._vertex})

    def strokes(self):
        if len(self.path) < 2:
            return []
        group = self.settings.pose_hold
        fixed = poses.of_group(self._obj, group) if group else poses.of_sculpt_mask(self._obj)
        held = poses.held(self._obj, fixed, [self._vertex])
        if not held:
            raise state.Refusal("Nothing holds: click on places that shall stay, or name a vertex group or paint a mask")
        parts = [{"pin": self._vertex, "path": np.array(self.path[1:])}, *held]
        if any(getattr(self._obj.data, f"use_mirror_{axis}") for axis in "xyz"):
            parts = [self._by_places(part) for part in parts]
        return [knead.Pose(parts=parts, detail=round(self._detail, 6))]

    def _by_places(self, part):
        """Returns the part by coordinates, which have mirror images."""
        part = dict(part)
        if "pin" in part:
            part["pin_point"] = self._vertices[part.pop("pin")]
        else:
            numbers = part.pop("vertices")
            part["points"] = self._vertices[numbers[:: len(numbers) // _MOST_POINTS + 1]]
        return part

    def ring_at(self):
        return self.point + self.path[-1] - self.path[0], self.normal, (_PIN_SIZE * self.live.size,)


ALL = {
    cls.__name__.lower(): cls
    for cls in (Move, Snakehook, Paint, Crease, Pinch, Flatten, Pull, Rotate, Stretch, Twist, Bend, Stamp, Pose)
}
