"""Points on disk, moved in pieces by dask: the bits of the whole, and memory for a few pieces alone.

KNEAD_SCALE is the number of points (default: 2 million)."""

import os
import pickle
import resource
import subprocess
import sys

import numpy as np
import pytest

import knead

dask_array = pytest.importorskip("dask.array", reason="dask is not installed; on Debian: apt-get install python3-dask")

PIECE = 250_000
DIAGONAL = 2 * 3**0.5  # of the cube in which the points lie


class OnDisk:
    """Points in a file as float32, of which dask reads and writes rows."""

    ndim, dtype = 2, np.dtype(np.float32)

    def __init__(self, path):
        self.path = path
        self.shape = (os.path.getsize(path) // 12, 3)

    def __getitem__(self, where):
        first, last, _ = where[0].indices(self.shape[0])
        return np.fromfile(self.path, np.float32, 3 * (last - first), offset=12 * first).reshape(-1, 3)

    def __setitem__(self, where, rows):
        with open(self.path, "r+b") as file:
            file.seek(12 * where[0].start)
            np.ascontiguousarray(rows).tofile(file)


def move(source, target, session):
    """Moves the points of a file into another one; returns the bytes by which the process grew."""
    knead.deform(np.zeros((PIECE, 3), np.float32), session, diagonal=DIAGONAL)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    points = dask_array.from_array(OnDisk(source), chunks=(PIECE, 3), meta=np.empty((0, 3), np.float32))
    moved = points.map_blocks(knead.deform, session, diagonal=DIAGONAL, dtype=np.float32, meta=np.empty((0, 3), np.float32))
    moved.store(OnDisk(target), lock=False, scheduler="threads", num_workers=2)
    return 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)


def test_points_on_disk_have_the_bits_of_the_whole(tmp_path):
    count = int(os.environ.get("KNEAD_SCALE", 2_000_000))
    numbers = np.random.default_rng(3)
    source, target, session_file = tmp_path / "in", tmp_path / "out", tmp_path / "session"
    with open(source, "wb") as file, open(target, "wb") as out:
        for first in range(0, count, PIECE):
            numbers.uniform(-1, 1, (min(PIECE, count - first), 3)).astype(np.float32).tofile(file)
        out.truncate(12 * count)
    session = knead.Session([knead.Implicit(path=[[0, 0, 0], [0.3, 0.2, 0]], inner=0.2, outer=0.8),
                             knead.Twist(center=[0, 0, -0.5], axis=[0, 0, 1], rate_deg=40, inner=0, outer=0.9)])
    session_file.write_bytes(pickle.dumps(session))
    done = subprocess.run([sys.executable, __file__, source, target, session_file], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    whole = knead.deform(np.fromfile(source, np.float32).reshape(-1, 3), session, diagonal=DIAGONAL)
    assert np.array_equal(np.fromfile(target, np.uint32), whole.view(np.uint32).ravel())
    assert not np.array_equal(np.fromfile(source, np.float32), whole.ravel())
    assert int(done.stdout) < 30 * 12 * PIECE  # two pieces at a time, with their results and what deform needs


if __name__ == "__main__":
    with open(sys.argv[3], "rb") as stored:
        print(move(sys.argv[1], sys.argv[2], pickle.load(stored)))
