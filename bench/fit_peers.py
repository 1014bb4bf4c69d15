"""Other programs that fit shapes, one setting each, for fit_bench.py.

    python fit_peers.py NAME IN.npz OUT.npy

IN.npz holds source and target, (n, 3); faces, (m, 3), of both; chosen, vertices that are landmarks. OUT.npy: where the
source's vertices end. Needs pycpd, trimesh, rtree, scipy and pyfmaps.
"""

import sys

import numpy as np


def cpd(source, target, faces, chosen):
    """Coherent point drift of 3000 points of each shape (pycpd), which knows no landmarks."""
    import pycpd

    some = np.unique(np.linspace(0, len(source) - 1, 3000).astype(int))
    size = np.linalg.norm(np.ptp(source, axis=0))
    fit = pycpd.DeformableRegistration(X=target[some] / size, Y=source[some] / size, alpha=2, beta=0.2, max_iterations=100)
    from scipy.interpolate import RBFInterpolator

    moved, _ = fit.register()
    by = RBFInterpolator(source[some], moved * size - source[some], neighbors=30, kernel="thin_plate_spline")
    return source + by(source)


def nricp(source, target, faces, chosen):
    """Non-rigid iterative closest points after Amberg et al. 2007 (trimesh)."""
    import trimesh

    shapes = [trimesh.Trimesh(v, faces, process=False) for v in (source, target)]
    marks = {"source_landmarks": chosen, "target_positions": target[chosen]} if len(chosen) else {}
    return np.asarray(trimesh.registration.nricp_amberg(*shapes, **marks))


def spline(source, target, faces, chosen):
    """The thin plate spline of the landmarks (scipy)."""
    from scipy.interpolate import RBFInterpolator

    return source + RBFInterpolator(source[chosen], target[chosen] - source[chosen], kernel="thin_plate_spline")(source)


def functional(source, target, faces, chosen):
    """A functional map refined by ZoomOut (pyfmaps): each vertex goes to one of the target's."""
    from pyFM.functional import FunctionalMapping
    from pyFM.mesh import TriMesh

    fit = FunctionalMapping(TriMesh(target, faces), TriMesh(source, faces))
    pairs = np.stack([chosen, chosen], axis=1) if len(chosen) else None
    fit.preprocess(n_descr=100, landmarks=pairs, subsample_step=4, descr_type="WKS", k_process=120)
    fit.fit(K=(35, 35), w_descr=1, w_lap=1e-2, w_dcomm=1e-1, w_orient=0 if len(chosen) else 1e-2)
    fit.zoomout_refine(nit=8, step=10)
    return target[np.asarray(fit.get_p2p())]


PEERS = {"cpd": cpd, "nricp": nricp, "spline": spline, "functional": functional}


def main():
    name, before, after = sys.argv[1:]
    with np.load(before) as data:
        moved = PEERS[name](data["source"], data["target"], data["faces"], data["chosen"].astype(int))
    np.save(after, np.asarray(moved, float))


if __name__ == "__main__":
    main()
