"""How the filter of ParaView scales over ranks: hexahedra read from one file a rank, moved by two strokes.

    /usr/bin/python3 bench/paraview_bench.py Knead.so FOLDER [--quality] [RANKS:POINTS[:REPEATS] ...]

POINTS counts those of all ranks, in thousands. Each run writes its pieces into FOLDER (a grid of shaken points as
legacy VTK files, 100 bytes a point), starts itself under mpirun and pvbatch, and deletes the pieces. Each rank is bound
to one core, so it works with one thread; with more ranks than cores, ranks share a core.

Prints seconds, the median of REPEATS (3), each of the slowest rank: reading from the disk, once, and again from the
memory of the system; the filter and its parts from ParaView's timer log. "exchange" is the time in reductions, each
taken from the rank that comes last to it; "waiting" is what the rank that waits most spends in them beyond that. "GB"
is the most that a rank took, without repeats by the filter, with repeats mostly by reading again. Needs mpirun, ParaView
and numpy.
"""

import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

PARTS = ["copy", "box", "kernel", "cells", "arrays"]
CORNERS = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)]
DEFAULT = ["1:10000", "2:10000", "4:10000", "1:50000", "2:50000", "4:50000", "1:5000", "4:20000", "1:25000"]


def write_piece(path, side, begin, end):
    """The planes from `begin` to `end`, both included, of a grid of side^3 points in the box from -1 to 1."""
    import numpy as np

    planes, spacing = end - begin + 1, 2 / (side - 1)
    axis = np.linspace(-1, 1, side)
    with open(path, "wb") as file:
        file.write(b"# vtk DataFile Version 5.1\npiece\nBINARY\nDATASET UNSTRUCTURED_GRID\n")
        file.write(f"POINTS {planes * side**2} double\n".encode())
        for plane in range(begin, end + 1):  # a plane that two pieces have is the same in both
            points = np.stack(np.meshgrid(axis, axis, axis[plane], indexing="ij"), -1)
            points += np.random.default_rng(plane).uniform(-0.1 * spacing, 0.1 * spacing, points.shape)
            file.write(points.astype(">f8").tobytes())
        cells = (planes - 1) * (side - 1) ** 2
        file.write(f"\nCELLS {cells + 1} {8 * cells}\nOFFSETS vtktypeint64\n".encode())
        file.write(np.arange(0, 8 * cells + 1, 8).astype(">i8").tobytes())
        file.write(b"\nCONNECTIVITY vtktypeint64\n")
        first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1, 1)
        layer = first + [z * side**2 + x * side + y for z, y, x in CORNERS]
        for plane in range(planes - 1):
            file.write((layer + plane * side**2).astype(">i8").tobytes())
        file.write(f"\nCELL_TYPES {cells}\n".encode())
        file.write(np.full(cells, 12, ">i4").tobytes())


def write_data(folder, ranks, points):
    side = round((1000 * points) ** (1 / 3))
    cuts = [round(i * (side - 1) / ranks) for i in range(ranks + 1)]
    names = [os.path.join(folder, f"piece_{i}.vtk") for i in range(ranks)]
    for name, begin, end in zip(names, cuts, cuts[1:]):
        write_piece(name, side, begin, end)
        with open(name, "rb") as file:  # so that reading begins at the disk
            os.fsync(file.fileno())
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    with open(os.path.join(folder, "all.pvtk"), "w") as file:
        file.write(f'<File version="pvtk-1.0" dataType="vtkUnstructuredGrid" numberOfPieces="{ranks}">\n')
        file.writelines(f'<Piece fileName="{name}"/>\n' for name in names)
        file.write("</File>\n")
    with open(os.path.join(folder, "two.knead"), "w") as file:
        file.write('{"knead": 1}\n')
        for shift in (0.08, -0.06):
            path = [[0, 0, 0], [shift, 0, shift]]
            file.write(json.dumps({"tool": "implicit", "path": path, "inner": 0.3, "outer": 1}) + "\n")


def run(plugin, folder, quality, spec):
    """One line of the table."""
    ranks, points, *repeats = [int(part) for part in spec.split(":")]
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        write_data(scratch, ranks, points)
        job = ["pvbatch", __file__, "--job", plugin, scratch, str(int(quality)), str(repeats[0] if repeats else 3)]
        command = ["mpirun", "--allow-run-as-root", "--bind-to", "core:overload-allowed", "--oversubscribe"]
        command += ["-np", str(ranks), *job]
        environment = os.environ | {"OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
        process = subprocess.Popen(command, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"failed: {' '.join(command)}")
        with open(os.path.join(scratch, "times.json")) as file:
            row = json.load(file) | {"GB": usage.ru_maxrss / 2**20}
    print("|", " | ".join([str(ranks), f"{row.pop('points'):,}", *(number(x) for x in row.values())]), "|", flush=True)


def number(x):
    return "" if x is None else f"{x:.4f}" if x < 0.1 else f"{x:.2f}" if x < 100 else f"{x:.0f}"


# --- what pvbatch does ------------------------------------------------------------------------------------------------


def executions(lines, name):
    """The parts of each execution of a proxy in one rank's timer log: "all", and lists of seconds by name."""
    found = []
    depth = None
    for line in lines:
        match = re.match(r"( *)(.+?) *, +([\d.e+-]+) +seconds", line)
        if not match:
            continue
        indent, what, seconds = len(match[1]), match[2], float(match[3])
        if depth is not None and indent <= depth:
            depth = None
        if what.startswith("Execute " + name):
            depth = indent
            found.append({"all": seconds})
        elif depth is not None and what.startswith("Knead: "):
            found[-1].setdefault(what[7:], []).append(seconds)
    return found


def summary(ranks):
    """Medians over the executions of the slowest rank's seconds. ranks: executions() of each."""
    rows = []
    for same in zip(*ranks):
        row = {"filter": max(x["all"] for x in same)}
        row |= {part: max(sum(x.get(part, [])) for x in same) for part in PARTS}
        exchanges = [x.get("exchange", []) for x in same]
        row["exchange"] = sum(min(each) for each in zip(*exchanges))
        row["waiting"] = max(sum(each) for each in exchanges) - row["exchange"]
        rows.append(row)
    return {key: statistics.median(row[key] for row in rows) for key in rows[0]}


def job(plugin, folder, quality, repeats):
    from paraview import simple
    from paraview.benchmark import logbase

    simple.LoadPlugin(plugin)
    logbase.maximize_logs()
    source = simple.OpenDataFile(os.path.join(folder, "all.pvtk"))
    source.UpdatePipeline()
    moved = simple.Knead(Input=source, SessionFile=os.path.join(folder, "two.knead"), Quality=quality)
    for i in range(repeats):
        moved.Diagonal = 3.46 + 1e-9 * i  # makes the pipeline work again
        moved.UpdatePipeline()
    points = moved.GetDataInformation().GetNumberOfPoints()
    simple.Delete(moved)
    for _ in range(repeats if repeats > 1 else 0):
        simple.ReloadFiles(source)
        source.UpdatePipeline()
    logbase.get_logs()
    logs = [log.lines for log in logbase.logs]
    reading = [executions(lines, "PartitionedLegacyVTKReader") for lines in logs]
    reads = [max(x["all"] for x in same) for same in zip(*reading)]
    row = {"points": points, "from the disk": reads[0], "again": statistics.median(reads[1:]) if reads[1:] else None}
    row |= summary([executions(lines, "Knead") for lines in logs])
    with open(os.path.join(folder, "times.json"), "w") as file:
        json.dump(row, file)


def main():
    given = [a for a in sys.argv[1:] if a != "--quality"]
    if given[0] == "--job":
        job(given[1], given[2], int(given[3]), int(given[4]))
        return
    columns = ["ranks", "points", "reading", "again", "filter", *PARTS, "exchange", "waiting", "GB"]
    print("|", " | ".join(columns), "|\n|", " | ".join("---:" for _ in columns), "|")
    for spec in given[2:] or DEFAULT:
        run(os.path.abspath(given[0]), os.path.abspath(given[1]), "--quality" in sys.argv, spec)


main()
