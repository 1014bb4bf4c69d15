"""knead.skin and `knead skin`: an arm of two bones keeps its volume, and a glTF file of it gets corrective shapes."""

import json
import os
import struct
import subprocess

import numpy as np
import pytest

import knead


def turn(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


@pytest.fixture(scope="module")
def arm():
    """A cylinder about x, weights of two bones, and where they are at rest."""
    turns, rings = 16, 41
    angle = 2 * np.pi * np.arange(turns) / turns
    x = np.linspace(-3, 3, rings)
    side = np.stack([np.repeat(x, turns), np.tile(0.5 * np.cos(angle), rings), np.tile(0.5 * np.sin(angle), rings)], axis=1)
    v = np.concatenate([side, [[-3, 0, 0], [3, 0, 0]]])
    i = np.arange((rings - 1) * turns)
    after = i - i % turns + (i + 1) % turns
    k, next_k = np.arange(turns), (np.arange(turns) + 1) % turns
    top = (rings - 1) * turns
    ends = np.full(turns, len(side)), np.full(turns, len(side) + 1)
    faces = np.concatenate(
        [
            np.stack([i, after, after + turns], axis=1),
            np.stack([i, after + turns, i + turns], axis=1),
            np.stack([next_k, k, ends[0]], axis=1),
            np.stack([top + k, top + next_k, ends[1]], axis=1),
        ]
    )
    w = np.clip(0.5 + v[:, 0] / 1.2, 0, 1)
    rest = np.tile(np.eye(4), (2, 1, 1))
    rest[0, 0, 3] = -3
    return v, faces, np.stack([1 - w, w], axis=1), rest


def posed(rest, degrees):
    pose = rest.copy()
    pose[1] = turn(degrees) @ rest[1]
    return pose


def test_a_bent_arm_keeps_its_volume(arm):
    v, faces, weights, rest = arm
    result = knead.skin(v, faces, weights, rest, posed(rest, 90), parents=[-1, 0])
    assert abs(result.report["flow"]["volume_error"]) < 2e-3 < -result.report["linear"]["volume_error"]
    assert result.report["flow"]["crossings_new"] == 0
    assert np.array_equal(knead.deform(v, result.session), result.vertices)
    assert "new crossings" in repr(result)
    # The corrective shape, blended linearly, is the pose.
    motion = posed(rest, 90) @ np.linalg.inv(rest)
    blend = np.einsum("vb,bij->vij", weights, motion)
    back = np.einsum("vij,vj->vi", blend[:, :3, :3], result.corrective) + blend[:, :3, 3]
    assert np.abs(back - result.vertices).max() < 1e-9


def test_weights_come_as_arrays_pairs_or_sparse_rows(arm):
    v, faces, weights, rest = arm
    dense = knead.skin(v, faces, weights, rest, posed(rest, 30), measured=False).vertices
    pairs = (np.tile([0, 1], (len(v), 1)), weights)
    assert np.array_equal(knead.skin(v, faces, pairs, rest, posed(rest, 30), measured=False).vertices, dense)
    several = knead.skin(v, faces, weights, rest, np.stack([rest, posed(rest, 30)]), measured=False)
    assert np.array_equal(several[1].vertices, dense) and np.array_equal(several[0].vertices, v)


def test_correctives_are_driven_by_their_joints(arm):
    v, faces, weights, rest = arm
    made = knead.correctives(v, faces, weights, rest, posed(rest, 60), parents=[-1, 0])
    assert [list(c.bones) for c in made] == [[1]] and "60" in repr(made[0])
    assert np.allclose(made[0].axes, [[0, 0, 1]]) and np.allclose(made[0].angles_deg, [60])
    whole = knead.skin(v, faces, weights, rest, posed(rest, 60), parents=[-1, 0], measured=False)
    assert np.array_equal(v + made[0].offsets, whole.corrective) or np.abs(v + made[0].offsets - whole.corrective).max() < 1e-9


def test_what_does_not_fit_is_named(arm):
    v, faces, weights, rest = arm
    with pytest.raises(knead.InvalidInput, match="rows for"):
        knead.skin(v, faces, weights[1:], rest, rest)
    with pytest.raises(knead.InvalidInput, match="pose has 1"):
        knead.skin(v, faces, weights, rest, rest[:1])
    with pytest.raises(knead.InvalidInput, match="matrices"):
        knead.skin(v, faces, weights, rest[:, :3], rest)
    with pytest.raises(knead.InvalidInput, match="circle"):
        knead.skin(v, faces, weights, rest, rest, parents=[1, 0])


def write_glb(path, arm, degrees):
    """A skinned mesh in glTF, whose second joint turns by so many degrees in a second."""
    v, faces, weights, rest = arm
    blobs, views, accessors = b"", [], []

    def add(array, kind, component, **more):
        nonlocal blobs
        data = np.ascontiguousarray(array).tobytes()
        views.append({"buffer": 0, "byteOffset": len(blobs), "byteLength": len(data)})
        blobs += data + b"\0" * (-len(data) % 4)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind, **more})
        return len(accessors) - 1

    p = v.astype("<f4")
    position = add(p, "VEC3", 5126, min=p.min(axis=0).tolist(), max=p.max(axis=0).tolist())
    joints = add(np.tile(np.array([0, 1, 0, 0], dtype="u1"), (len(v), 1)), "VEC4", 5121)
    weight = add(np.concatenate([weights, np.zeros_like(weights)], axis=1).astype("<f4"), "VEC4", 5126)
    index = add(faces.astype("<u4").ravel(), "SCALAR", 5125)
    bind = add(np.linalg.inv(rest).transpose(0, 2, 1).astype("<f4"), "MAT4", 5126)
    times = add(np.array([0, 1], dtype="<f4"), "SCALAR", 5126, min=[0], max=[1])
    half = np.radians(degrees) / 2
    turns = add(np.array([[0, 0, 0, 1], [0, 0, np.sin(half), np.cos(half)]], dtype="<f4"), "VEC4", 5126)
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0, "skin": 0},
            {"name": "upper", "translation": [-3, 0, 0], "children": [2]},
            {"name": "lower", "translation": [3, 0, 0]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weight}, "indices": index}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": bind}],
        "animations": [
            {
                "samplers": [{"input": times, "output": turns}],
                "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
            }
        ],
        "bufferViews": views,
        "accessors": accessors,
        "buffers": [{"byteLength": len(blobs)}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blobs)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(blobs), b"BIN\0") + blobs)


def read_glb(path):
    data = path.read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def numbers(scene, blob, index):
    accessor = scene["accessors"][index]
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    result = np.zeros((accessor["count"], width))

    def floats(view, count):
        begin = scene["bufferViews"][view].get("byteOffset", 0)
        return np.frombuffer(blob, "<f4", count * width, begin).reshape(-1, width)

    if "bufferView" in accessor:
        result[:] = floats(accessor["bufferView"], accessor["count"])
    if "sparse" in accessor:
        sparse = accessor["sparse"]
        begin = scene["bufferViews"][sparse["indices"]["bufferView"]].get("byteOffset", 0)
        kind = {5123: "<u2", 5125: "<u4"}[sparse["indices"]["componentType"]]
        result[np.frombuffer(blob, kind, sparse["count"], begin)] = floats(sparse["values"]["bufferView"], sparse["count"])
    return result


def command(*words):
    return subprocess.run([os.environ["KNEAD"], "skin", *map(str, words)], capture_output=True, text=True)


@pytest.mark.skipif("KNEAD" not in os.environ, reason="KNEAD names no command")
def test_the_command_poses_and_corrects_a_gltf_file(arm, tmp_path):
    v, faces, weights, rest = arm
    source, out, session = tmp_path / "arm.glb", tmp_path / "arm.ply", tmp_path / "arm.knead"
    write_glb(source, arm, 80)
    ran = command(source, "--time", 1, "--session", session, "--json", "-o", out)
    assert ran.returncode == 0, ran.stderr
    report = json.loads(ran.stdout)
    assert abs(report["flow"]["volume_error"]) < 2e-3 and report["flow"]["crossings_new"] == 0
    there = knead.read(out).vertices
    wanted = knead.skin(v, faces, weights, rest, posed(rest, 80), parents=[-1, 0]).vertices
    # The file's numbers are floats, and a vertex that is just rigid may be just flesh there.
    assert np.linalg.norm(there - wanted, axis=1).mean() < 0.05
    assert np.abs(knead.deform(knead.read(source).vertices, knead.Session.read(session)) - there).max() < 1e-5

    pose = tmp_path / "pose.json"
    pose.write_text(json.dumps({"lower": {"axis": [0, 0, 1], "angle_deg": 80}}))
    assert command(source, "--pose", pose, "-o", tmp_path / "other.ply").returncode == 0
    assert np.linalg.norm(knead.read(tmp_path / "other.ply").vertices - there, axis=1).mean() < 0.05

    corrected = tmp_path / "corrected.glb"
    ran = command(source, "--fps", 4, "-o", corrected)
    assert ran.returncode == 0, ran.stderr
    scene, blob = read_glb(corrected)
    mesh = scene["meshes"][0]
    assert mesh["extras"]["targetNames"] == ["knead lower"] and mesh["weights"] == [0]
    channels = scene["animations"][0]["channels"]
    assert [c["target"]["path"] for c in channels] == ["rotation", "weights"]
    sampler = scene["animations"][0]["samplers"][channels[1]["sampler"]]
    assert np.allclose(numbers(scene, blob, sampler["output"]).ravel(), [0, 1 / 16, 1 / 4, 9 / 16, 1], atol=1e-6)
    target = numbers(scene, blob, mesh["primitives"][0]["targets"][0]["POSITION"])
    motion = posed(rest, 80) @ np.linalg.inv(rest)
    blend = np.einsum("vb,bij->vij", weights, motion)
    shown = np.einsum("vij,vj->vi", blend[:, :3, :3], v + target) + blend[:, :3, 3]
    assert np.linalg.norm(shown - there, axis=1).mean() < 0.05
    assert np.abs(target).max() > 1e-3
    assert "skins" in scene


@pytest.mark.skipif("KNEAD" not in os.environ, reason="KNEAD names no command")
def test_a_spoiled_pose_is_written_and_ends_with_4(arm, tmp_path):
    v, faces, weights, rest = arm
    weights = np.stack([weights[:, 0] >= 0.5, weights[:, 0] < 0.5], 1).astype(float)  # no flesh between the bones
    source, pose = tmp_path / "arm.glb", tmp_path / "pose.json"
    write_glb(source, (v, faces, weights, rest), 80)
    pose.write_text(json.dumps({"lower": {"axis": [0, 0, 1], "angle_deg": 178}}))
    for name in ("folded.ply", "folded.glb"):
        ran = command(source, "--pose", pose, "-o", tmp_path / name)
        assert ran.returncode == 4 and (tmp_path / name).exists(), ran
        assert "turn these joints less" in ran.stderr.strip().splitlines()[-1], ran.stderr
    folded = knead.skin(v, faces, weights, rest, posed(rest, 178), parents=[-1, 0])
    assert "turn these joints less" in folded.problem
    made = knead.correctives(v, faces, weights, rest, posed(rest, 178), parents=[-1, 0])
    assert made and not any(one.problem for one in made)  # they are made for where the pose came to
    assert not knead.skin(v, faces, weights, rest, posed(rest, 60), parents=[-1, 0]).problem


def test_limbs_that_cannot_follow_their_bones_end_on_the_way(arm):
    v, faces, weights, rest = arm
    assert "there is no room for them" in knead.skin(v * [1, 5, 5], faces, weights, rest, posed(rest, 90), parents=[-1, 0]).problem


@pytest.mark.skipif("KNEAD" not in os.environ, reason="KNEAD names no command")
def test_wrong_words_and_files_are_one_line(arm, tmp_path):
    source = tmp_path / "arm.glb"
    write_glb(source, arm, 80)
    knead.write(tmp_path / "plain.ply", arm[0], arm[1])
    (tmp_path / "pose.json").write_text('{"elbow": {"axis": [0, 0, 1], "angle_deg": 80}}')
    for words, code, what in [
        ([tmp_path / "plain.ply", "-o", tmp_path / "o.ply"], 3, "only glTF files"),
        ([source, "--time", 1, "--frames", 3, "-o", tmp_path / "o.pc2"], 2, "--frames"),
        ([source, "--pose", tmp_path / "pose.json", "-o", tmp_path / "o.ply"], 3, "no bone"),
        ([source, "--animation", 4, "-o", tmp_path / "o.ply"], 3, "no animation 4"),
        ([source, "-o", source], 2, ""),
        ([source, "-o", tmp_path / "still.xyz.abc"], 3, ""),
    ]:
        ran = command(*words)
        assert ran.returncode in (code, 2 if code == 3 and not what else code) and what in ran.stderr, ran
        assert ran.stderr.count("\n") <= 2
    assert not (tmp_path / "o.ply").exists()
