"""Strokes as segments, and their integration by scipy, independent of Knead. For check_agreement.py."""
import numpy as np
from scipy.integrate import solve_ivp

from agreement_fields import assembled, ball, capsule, cross, dot, point_set, turned, unit

FRACTION = 0.4867502159528536


def worst(a, b, diagonal):
    gap = np.sqrt(((a.astype(float) - b.astype(float)) ** 2).sum(1)) / diagonal
    return gap


class Segment:
    """velocity(x, t), region(x, t) -> r, and what a step and the outside may be judged by."""

    def __init__(self, velocity, region, inner, outer, speed=0.0, started=None, static=False):
        self.velocity, self.region = velocity, region
        self.inner, self.outer, self.speed = inner, outer, speed
        self.started = started  # which points are moved at all, by where they are when the stroke begins
        self.max_step = min(0.02 if not static else 0.05, (outer - inner) / speed / 6 if speed else 1)


def ball_or_capsule(stroke, c0, c1, blended):
    inner, outer = stroke.get("inner", 0.0), stroke["outer"]
    u = c1 - c0
    h = np.array(stroke["half_axis"], float) if stroke.get("region") == "capsule" else None

    def at(x, c):
        d = x - c
        potential = cross(u, d) / 2
        if h is None:
            r, grad = ball(x, c)
        else:
            r, grad = capsule(x, c, h)
            a = unit(h)
            along = (u @ a) * a
            other = cross(along, d) / 2 + (d @ np.cross(a, u - along))[:, None] * a
            g = stroke.get("gauge", 0)
            potential = g * potential + (1 - g) * other
        return assembled(r, grad, np.broadcast_to(u, x.shape), potential, inner, outer)

    def region(x, t):
        def one(c):
            return ball(x, c)[0] if h is None else capsule(x, c, h)[0]
        return np.minimum(one(c0), one(c1)) if blended else one(c0 + t * u)

    if blended:
        def velocity(x, t):
            return (1 - t) * at(x, c0) + t * at(x, c1)
    else:
        def velocity(x, t):
            return at(x, c0 + t * u)
    return Segment(velocity, region, inner, outer, np.sqrt(u @ u))


def parts_of(points, curves, reach, together):
    """Components of the elements under distance < reach: list of (points, curves, barycentre)."""
    def dense(line):
        return np.concatenate([np.linspace(p, q, 200) for p, q in zip(line[:-1], line[1:])])
    elements = [("p", p, p[None]) for p in points] + [("c", c, dense(c)) for c in curves]
    label = list(range(len(elements)))
    if together:
        label = [0] * len(elements)
    else:
        for i in range(len(elements)):
            for j in range(i):
                gap = np.sqrt(((elements[i][2][:, None] - elements[j][2][None]) ** 2).sum(-1)).min()
                if gap < reach and label[i] != label[j]:
                    old, new = label[i], label[j]
                    label = [new if k == old else k for k in label]
    result = []
    for k in sorted(set(label)):
        p = [e[1] for e, l in zip(elements, label) if l == k and e[0] == "p"]
        c = [e[1] for e, l in zip(elements, label) if l == k and e[0] == "c"]
        result.append((p, c, barycentre(p, c, reach)))
    return result


def barycentre(points, curves, outer):
    """A point weighs 1, a piece of a curve its length / outer (docs/mathematics.md)."""
    weighted = [(1.0, p) for p in points]
    for line in curves:
        weighted += [(np.sqrt((q - p) @ (q - p)) / outer, (p + q) / 2) for p, q in zip(line[:-1], line[1:])]
    return np.average([p for _, p in weighted], axis=0, weights=[w for w, _ in weighted])


def segments_of(stroke):
    tool = stroke["tool"]
    if tool == "implicit":
        path = np.array(stroke["path"], float)
        return [ball_or_capsule(stroke, p, q, stroke.get("time") == "blended")
                for p, q in zip(path[:-1], path[1:]) if (p != q).any()]
    if tool == "paint":
        result = []
        for sample in stroke["samples"]:
            c0 = np.array(sample["point"], float)
            result.append(ball_or_capsule(stroke, c0, c0 - stroke["depth"] * unit(sample["normal"]), False))
        return result
    if tool == "points":
        points = [np.array(p, float) for p in stroke.get("points", [])]
        curves = [np.array(c, float) for c in stroke.get("curves", [])]
        m, inner, outer = stroke.get("exponent", 8), stroke.get("inner", 0.0), stroke["outer"]
        result = []
        for move in stroke["displacements"]:
            u = np.array(move, float)
            if (u == 0).all():
                continue
            parts = parts_of(points, curves, outer, stroke.get("center") == "barycentre")

            def velocity(x, t, u=u, parts=parts):
                v = np.zeros_like(x)
                for p, c, centre in parts:
                    y = x - t * u
                    r, grad = point_set(y, p, c, m)
                    v += assembled(r, grad, np.broadcast_to(u, x.shape), cross(u, y - centre) / 2, inner, outer)
                return v

            def region(x, t, u=u, parts=parts):
                return np.min([point_set(x - t * u, p, c, m)[0] for p, c, _ in parts], axis=0)
            result.append(Segment(velocity, region, inner, outer, np.sqrt(u @ u)))
            points = [p + u for p in points]
            curves = [c + u for c in curves]
        return result

    c = np.array(stroke["center"], float)
    a = unit(stroke["axis"])
    if tool == "rotate":
        omega, g = np.radians(stroke["angle_deg"]), stroke.get("gauge", 0)

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            return omega * cross(a, d), (g * omega / 2 * (h * across - dot(across, across)[:, None] / 2 * a)
                                         + (1 - g) * omega * h * d)
        speed = 0
    if tool == "stretch":
        matrix = np.log(stroke["factor"]) * (np.outer(a, a) - (np.eye(3) - np.outer(a, a)) / 2)

        def inside(d):
            return d @ matrix.T, cross(d @ matrix.T, d) / 3
    if tool in ("rotate", "stretch"):
        inner, outer = stroke["inner"], stroke["outer"]

        def velocity(x, t):
            return assembled(*ball(x, c), *inside(x - c), inner, outer)
        return [Segment(velocity, lambda x, t: ball(x, c)[0], inner, outer, static=True)]

    n = unit(stroke.get("normal", stroke["axis"]))
    if tool == "twist":
        tau, g = np.radians(stroke["rate_deg"]), stroke.get("gauge", 0)
        inner, outer, half = stroke["inner"], stroke["outer"], 0.0

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            q = dot(across, across)[:, None]
            return tau * h * cross(a, d), g * tau / 4 * (h * h * across - q * h * a) - (1 - g) * tau / 2 * h * q * a
    else:
        omega, g = np.radians(stroke["angle_deg"]), stroke.get("gauge", 1)
        half = omega / 2
        if "width" in stroke:
            f = stroke.get("center_fraction", FRACTION)
            inner, outer = -f * stroke["width"], (1 - f) * stroke["width"]
        else:
            inner, outer = stroke["inner"], stroke["outer"]

        def inside(d):
            h = (d @ a)[:, None]
            across = d - h * a
            q = dot(across, across)[:, None]
            return omega * cross(a, d), g * omega / 2 * (h * across - q / 2 * a) - (1 - g) * omega / 2 * q * a

    def velocity(x, t):
        normal = turned(n, a, half * t)
        return assembled((x - c) @ normal, normal, *inside(x - c), inner, outer)

    def region(x, t):
        return (x - c) @ turned(n, a, half * t)
    started = None
    if "radius" in stroke:
        def started(x):
            d = x - c
            d = d - (d @ n)[:, None] * n
            return np.sqrt(dot(d, d)) <= stroke["radius"]
    return [Segment(velocity, region, inner, outer, started=started, static=True)]


def flow_of(events, until=None):
    """(segment, fraction of it) in order."""
    done, undone = [], []
    for event in events:
        if "undo" in event:
            for _ in range(event["undo"]):
                undone.append(done.pop())
        elif "redo" in event:
            for _ in range(event["redo"]):
                done.append(undone.pop())
        else:
            done.append(event)
            undone = []
    result = []
    for k, stroke in enumerate(done):
        segments = segments_of(stroke)
        share = 1.0 if until is None else min(max(until - k, 0.0), 1.0)
        for j, segment in enumerate(segments):
            part = min(max(share * len(segments) - j, 0.0), 1.0)
            if part > 0:
                result.append((segment, part))
    return result


def integrate(flow, x, diagonal, finer=1, together=75):
    x = np.array(x, float)
    for segment, part in flow:
        live = np.ones(len(x), bool) if segment.started is None else segment.started(x)
        # who can be reached at all is not guessed: everything is integrated, in chunks
        for chunk in np.array_split(np.flatnonzero(live), max(1, len(x) // together)):
            if len(chunk) == 0:
                continue

            def slope(t, y):
                return segment.velocity(y.reshape(-1, 3), t).ravel()
            done = solve_ivp(slope, (0.0, part), x[chunk].ravel(), method="DOP853", rtol=1e-13,
                             atol=1e-13 * diagonal, max_step=segment.max_step / finer)
            assert done.success, done.message
            x[chunk] = done.y[:, -1].reshape(-1, 3)
    return x


def agreement(flow, x, computed, diagonal, bar):
    """The distance of the computed points from the truth. DOP853's own estimate is blind to the jump of v's second
    derivative at the inner threshold: what lies beyond the bar is judged again by shorter and shorter steps."""
    truth = integrate(flow, x, diagonal)
    for finer in (16, 128):
        doubtful = np.flatnonzero(worst(computed, truth, diagonal) > bar / 4)
        doubtful = doubtful[np.argsort(-worst(computed, truth, diagonal)[doubtful])][:8]
        if len(doubtful):
            truth[doubtful] = integrate(flow, x[doubtful], diagonal, finer, 1)
    return worst(computed, truth, diagonal).max(), truth


def surely_outside(flow, x):
    """Points that no region ever reaches: r >= ro at moments so dense that nothing slips through."""
    outside = np.ones(len(x), bool)
    for segment, part in flow:
        moments = 60 if segment.speed else 90
        slack = 1.5 * segment.speed * part / moments
        for t in np.linspace(0, part, moments + 1):
            index = np.flatnonzero(outside)
            clear = segment.region(x[index], t) > segment.outer * (1 + 1e-9) + slack
            if segment.started is not None:
                clear |= ~segment.started(x[index])
            outside[index[~clear]] = False
    return outside
