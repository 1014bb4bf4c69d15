"""What the tests in pvbatch share."""

import os
import sys
import traceback

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkParallelCore import vtkMultiProcessController

sys.path.insert(0, os.environ["KNEAD_PYTHON"])
import knead  # noqa: E402

scratch = os.environ["KNEAD_SCRATCH"]
simple.LoadPlugin(os.environ["KNEAD_PLUGIN"])
RANKS = vtkMultiProcessController.GetGlobalController().GetNumberOfProcesses()


def path_of(name):
    return os.path.join(scratch, name)


def session_file(name):
    return path_of(name + ".knead")


def opened(name):
    """A file as a source, split over the ranks. RedistributeDataSet would not do: Debian's build loses what it sends."""
    if RANKS > 1 and name.endswith(".vtu"):
        name = name.replace(".vtu", ".pvtu")
    return simple.OpenDataFile(path_of(name))


def deformed(source, session, **properties):
    result = simple.Knead(Input=source, SessionFile=session_file(session), **properties)
    result.UpdatePipeline()
    return result


def leaves(source):
    """The data sets of a source here: of all ranks, but for an unstructured grid of the first."""
    information = source.GetDataInformation().DataInformation
    if (information.GetCompositeDataClassName() or "").startswith("vtkPartitioned"):
        source = simple.MergeBlocks(Input=source, MergePoints=0)  # Fetch takes no such collection
    data = servermanager.Fetch(source)
    if not data.IsA("vtkCompositeDataSet"):
        return [data]
    iterator = data.NewIterator()
    found = []
    while not iterator.IsDoneWithTraversal():
        found.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return found


def cloud_of(source):
    """The points of a source, of all ranks; of an unstructured grid leaves() has those of the first rank only."""
    cloud = leaves(simple.ConvertToPointCloud(Input=source))[0]
    expected = source.GetDataInformation().GetNumberOfPoints()
    require(cloud.GetNumberOfPoints() == expected, f"{cloud.GetNumberOfPoints()} points of {expected}")
    return cloud


def points_of(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def array_of(attributes, name):
    array = attributes.GetArray(name)
    assert array is not None, f"there is no array {name}"
    return vtk_to_numpy(array)


def start_of(data):
    return array_of(data.GetPointData(), "KneadTestStart")


def diagonal_of(source):
    """The diagonal of all ranks' points; Fetch may bring a part of them only."""
    source.UpdatePipeline()
    bounds = np.array(source.GetDataInformation().GetBounds()).reshape(3, 2)
    return float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))


def require(condition, what):
    if not condition:
        raise AssertionError(what)


def say(*words):
    """Prints past ParaView, which takes print() for its messages."""
    os.write(1, (" ".join(map(str, words)) + "\n").encode())


def run_tests(tests):
    for name, test in list(tests.items()):
        if not name.startswith("test_"):
            continue
        try:
            test()
        except Exception:
            say("failed", name, traceback.format_exc())
            sys.exit(1)
        say("ok", name)
    say("passed")
