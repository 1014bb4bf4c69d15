"""The sessions that are checked, fitted to a mesh. For check_agreement.py."""
import numpy as np

from agreement_fields import dot, unit


# Cases ------------------------------------------------------------------------------------------------

def cylinders_of_parts(points, triangles, diagonal, rng, tool):
    """A centre, an axis along a thin part, thresholds and a limit cylinder that holds this part, and no other, of r < outer."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    middle = points.mean(0)
    best = None
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    far = np.argsort(-np.sqrt(((points - middle) ** 2).sum(1)))[: len(points) // 3]
    for tip in rng.choice(far, 60, replace=False):
        size = diagonal * rng.uniform(0.06, 0.12)
        near = np.sqrt(((points - points[tip]) ** 2).sum(1)) < 1.5 * size
        down = unit(points[near].mean(0) - points[tip] + 1e-9 * diagonal * rng.standard_normal(3))
        c = points[tip] + down * size
        outer = 0.2 * size
        low = (points - c) @ down < outer
        # a triangle counts as soon as one corner is low
        touched = low[triangles].any(1)
        kept = touched[np.arange(len(edges)) % len(triangles)]
        graph = coo_matrix((np.ones(kept.sum()), tuple(edges[kept].T)), shape=(len(points),) * 2)
        _, label = connected_components(graph, directed=False)
        part = label == label[tip]
        inside = np.zeros(len(points), bool)
        inside[np.unique(triangles[touched])] = True
        d = points - c
        d = d - (d @ down)[:, None] * down
        away = np.sqrt(dot(d, d))
        widest = away[part & inside].max()
        others = away[inside & ~part]
        if len(others) == 0 or others.min() < 1.15 * widest or (part & inside).sum() < 100:
            continue
        score = others.min() / widest * min(1, size / widest)
        if best is None or score > best[0]:
            best = (score, c, down, outer, size, widest, (widest + min(others.min(), 2 * widest)) / 2)
    if best is None:
        return None
    _, c, down, outer, size, widest, radius = best
    across = unit(np.cross(down, [0.3, 0.5, 0.8]))
    if tool == "bend":
        stroke = {"tool": "bend", "center": c, "axis": across, "normal": down, "angle_deg": 50,
                  "inner": -0.7 * size, "outer": outer, "radius": radius}
    else:
        stroke = {"tool": "twist", "center": c, "axis": down, "rate_deg": 50 / size, "inner": -0.4 * size,
                  "outer": outer, "radius": radius}
    return stroke, 0.6 * widest


def cases(points, triangles, diagonal, rng):
    """Name -> list of events, placed on the shape and as strong as people use them."""
    box_min, box_max = points.min(0), points.max(0)
    middle = (box_min + box_max) / 2
    d = diagonal

    def surface():
        return points[rng.integers(len(points))]

    def direction():
        return unit(rng.standard_normal(3))

    def path(pieces, step):
        where, heading, result = surface() - 0.1 * d * direction(), direction(), []
        for _ in range(pieces + 1):
            result.append(where)
            heading = unit(heading + 0.35 * rng.standard_normal(3) + 0.6 * (middle - where) / d)
            where = where + step * d * heading
        return result

    out = {}
    out["implicit-swept"] = [{"tool": "implicit", "inner": 0.08 * d, "outer": 0.22 * d, "path": path(8, 0.05)}]
    out["implicit-through"] = [{"tool": "implicit", "inner": 0.05 * d, "outer": 0.12 * d,
                                "path": [middle - 0.6 * d * (q := direction()), middle + 0.5 * d * q]}]
    out["implicit-steep"] = [{"tool": "implicit", "inner": 0.12 * d, "outer": 0.16 * d, "path": path(3, 0.06)}]
    out["implicit-blended"] = [{"tool": "implicit", "inner": 0.08 * d, "outer": 0.22 * d, "time": "blended",
                                "path": path(6, 0.05)}]
    h = 0.12 * d * direction()
    out["capsule"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                       "outer": 0.13 * d, "path": path(4, 0.05)}]
    out["capsule-gauge"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                             "outer": 0.16 * d, "gauge": 0.7, "path": path(3, 0.05)}]
    out["capsule-blended"] = [{"tool": "implicit", "region": "capsule", "half_axis": h, "inner": 0.05 * d,
                               "outer": 0.15 * d, "time": "blended", "path": path(3, 0.05)}]
    start = surface()
    order = np.argsort(((points - start) ** 2).sum(1))
    samples = [{"point": points[order[k]], "normal": unit(points[order[k]] - middle)}
               for k in range(0, min(1200, len(points) // 6), 150)]
    out["paint"] = [{"tool": "paint", "outer": 0.07 * d, "depth": -0.02 * d, "samples": samples},
                    {"tool": "paint", "outer": 0.12 * d, "depth": 0.06 * d,
                     "samples": [{"point": surface(), "normal": 7.5 * direction()} for _ in range(3)]}]
    one, two = surface(), surface()
    cloud = [one + 0.03 * d * rng.standard_normal(3) for _ in range(5)] \
        + [two + 0.03 * d * rng.standard_normal(3) for _ in range(4)]
    moves = [0.08 * d * direction(), 0.06 * d * direction()]
    out["points-parts"] = [{"tool": "points", "points": cloud, "outer": 0.11 * d, "displacements": moves}]
    out["points-barycentre"] = [{"tool": "points", "points": cloud[:7], "outer": 0.15 * d, "exponent": 4,
                                 "center": "barycentre", "displacements": moves[:1]}]
    line = [one + 0.05 * d * np.array([np.cos(s), np.sin(s), 0.3 * s]) for s in np.linspace(0, 4, 6)]
    out["points-curve"] = [{"tool": "points", "curves": [line], "outer": 0.12 * d, "displacements": moves}]
    out["points-and-curves"] = [{"tool": "points", "curves": [line, [two, two + 0.1 * d * direction()]],
                                 "points": cloud[:2], "outer": 0.12 * d, "inner": 0.03 * d, "exponent": 6,
                                 "displacements": moves}]
    out["rotate"] = [{"tool": "rotate", "center": surface(), "axis": 3 * direction(), "angle_deg": 140,
                      "inner": 0.05 * d, "outer": 0.25 * d}]
    out["rotate-gauge"] = [{"tool": "rotate", "center": surface(), "axis": direction(), "angle_deg": -110,
                            "inner": 0.1 * d, "outer": 0.3 * d, "gauge": 1}]
    out["stretch"] = [{"tool": "stretch", "center": surface(), "axis": direction(), "factor": 2.2,
                       "inner": 0.1 * d, "outer": 0.4 * d},
                      {"tool": "stretch", "center": surface(), "axis": direction(), "factor": 0.6,
                       "inner": 0, "outer": 0.3 * d}]
    out["twist"] = [{"tool": "twist", "center": middle, "axis": direction(), "rate_deg": 220 / d,
                     "inner": -0.25 * d, "outer": 0.3 * d}]
    out["twist-gauge"] = [{"tool": "twist", "center": middle, "axis": direction(), "rate_deg": -160 / d,
                           "inner": -0.2 * d, "outer": 0.2 * d, "gauge": 1}]
    axis = direction()
    out["twist-oblique"] = [{"tool": "twist", "center": middle, "axis": axis, "normal": axis + 0.3 * direction(),
                             "rate_deg": 140 / d, "inner": -0.2 * d, "outer": 0.3 * d, "gauge": 0.4}]
    normal = np.cross(axis, direction())
    out["bend"] = [{"tool": "bend", "center": middle, "axis": axis, "normal": 2 * normal, "width": 0.5 * d,
                    "angle_deg": 80}]
    out["bend-gauge"] = [{"tool": "bend", "center": middle + 0.05 * d * axis, "axis": axis, "normal": normal,
                          "width": 0.6 * d, "center_fraction": 0.386, "angle_deg": -45, "gauge": 0}]
    out["bend-thresholds"] = [{"tool": "bend", "center": middle, "axis": axis, "normal": normal, "inner": -0.1 * d,
                               "outer": 0.35 * d, "angle_deg": 60, "gauge": 0.5}]
    out["session"] = out["implicit-blended"] + out["rotate"] + [{"undo": 2}, {"redo": 1}] + out["points-parts"] \
        + out["twist"] + [{"undo": 1}] + out["bend"]
    for tool in ("bend", "twist"):
        found = cylinders_of_parts(points, triangles, diagonal, rng, tool)
        if found:
            out["cylinder-" + tool] = [found[0]]
            out["cylinder-" + tool + "-refused"] = [dict(found[0], radius=found[1])]
    return out
