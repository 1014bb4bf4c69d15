"""How the filter of ParaView scales over ranks: a grid of points that ParaView splits, moved by two strokes.

    mpirun -np RANKS pvbatch bench/paraview_bench.py Knead.so POINTS [REPEATS]

POINTS counts those of all ranks. Prints the seconds of the filter (without Quality), the median of REPEATS (5), of the
filter with no stroke, which copies points, exchanges the box and judges the cells, and those of making the grid. mpirun binds each
of up to two ranks to a core, so each then works with one thread.
"""

import os
import statistics
import sys
import tempfile
import time

from paraview import simple
from vtkmodules.vtkParallelCore import vtkMultiProcessController

plugin, points = sys.argv[1], int(float(sys.argv[2]))
repeats = int(sys.argv[3]) if len(sys.argv) > 3 else 5
simple.LoadPlugin(plugin)
ranks = vtkMultiProcessController.GetGlobalController().GetNumberOfProcesses()
half = round(points ** (1 / 3)) // 2
scale = 100 / half  # the same box, whatever the number of points
with tempfile.NamedTemporaryFile("w", suffix=".knead", delete=False) as session:
    session.write('{"knead": 1}\n')
    for shift in (8, -6):
        session.write(f'{{"tool": "implicit", "path": [[0, 0, 0], [{shift / scale}, 0, {shift / scale}]], '
                      f'"inner": {30 / scale}, "outer": {90 / scale}}}\n')
grid = simple.Wavelet(WholeExtent=[-half, half] * 3)
began = time.perf_counter()
grid.UpdatePipeline()
making = time.perf_counter() - began
moved = simple.Knead(Input=grid, SessionFile=session.name, Quality=0)


def times(until):
    seconds = []
    moved.Until = until
    for i in range(repeats):
        moved.Diagonal = 346.0 / scale + 1e-9 * i  # makes the pipeline work again
        began = time.perf_counter()
        moved.UpdatePipeline()
        seconds.append(time.perf_counter() - began)
    return seconds


without = times(0)
seconds = times(2)
count = moved.GetDataInformation().GetNumberOfPoints()
os.remove(session.name)
print(f"{ranks} ranks, {count} points: filter {statistics.median(seconds):.2f} s "
      f"({min(seconds):.2f} to {max(seconds):.2f}), with no stroke {statistics.median(without):.2f} s, "
      f"grid {making:.2f} s", flush=True)
