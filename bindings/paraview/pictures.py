"""Makes the pictures of docs/paraview.md; needs a display, such as xvfb-run gives.

    xvfb-run -a -s "-screen 0 1280x1024x24" pvbatch bindings/paraview/pictures.py Knead.so FOLDER OUT

FOLDER holds what vessel.py makes; OUT gets vessel.jpg, stretch.jpg, quality.jpg and streamlines.jpg.
"""

import os
import sys

from paraview import simple

plugin, folder, out = sys.argv[1:]
simple.LoadPlugin(plugin)
view = simple.CreateRenderView(ViewSize=[900, 620])
view.OrientationAxesVisibility = 0
view.UseColorPaletteForBackground = 0
view.Background = [1, 1, 1]
grid = simple.XMLUnstructuredGridReader(FileName=[os.path.join(folder, "vessel.vtu")])
bulge = simple.Knead(Input=grid, SessionFile=os.path.join(folder, "bulge.knead"), VectorsToTransform=["velocity"])
bulge.UpdatePipeline()


def look():
    view.CameraPosition = [0.55, 0.95, 5.9]
    view.CameraFocalPoint = [0.12, 0.4, 0]
    view.CameraViewUp = [0, 1, 0]
    view.CameraViewAngle = 30


def picture(name, source, association=None, array=None, title="", red_is_low=False, around=None, **look_of):
    simple.HideAll(view)
    if around is not None:
        hull = simple.Show(around, view)
        simple.ColorBy(hull, None)
        hull.Opacity = 0.15
    shown = simple.Show(source, view)
    for key, value in look_of.items():
        setattr(shown, key, value)
    if array is None:
        shown.ColorArrayName = ["POINTS", ""]
        shown.DiffuseColor = shown.AmbientColor = [0.72, 0.45, 0.4]
    else:
        simple.ColorBy(shown, (association, array))
        shown.RescaleTransferFunctionToDataRange(False, True)
        table = simple.GetColorTransferFunction(array)
        if red_is_low:
            table.InvertTransferFunction()
        bar = simple.GetScalarBar(table, view)
        bar.Title, bar.ComponentTitle = title, ""
        bar.RangeLabelFormat, bar.LabelFormat, bar.AutomaticLabelFormat = "%.2g", "%.2g", 0
        bar.AddRangeLabels = 0  # they cover the others
        bar.TitleColor = bar.LabelColor = [0, 0, 0]
        shown.SetScalarBarVisibility(view, True)
    simple.Render(view)  # the first picture places the camera
    look()
    simple.Render(view)
    simple.SaveScreenshot(os.path.join(out, name), view, ImageResolution=[900, 620], Quality=90)


picture("vessel.jpg", grid, Representation="Surface With Edges", EdgeColor=[0.45, 0.25, 0.2])
picture("stretch.jpg", bulge, "POINTS", "KneadStretch", "greatest stretch")
cut = simple.Clip(Input=bulge, ClipType="Plane")
cut.ClipType.Normal = [0, 0, 1]
cut.ClipType.Origin = [0, 0, 0]
picture("quality.jpg", cut, "CELLS", "KneadScaledJacobian", "scaled Jacobian", red_is_low=True)
lines = simple.StreamTracer(Input=bulge, Vectors=["POINTS", "velocity"], SeedType="Point Cloud", MaximumStreamlineLength=12)
lines.SeedType.Center = [0.78, -0.49, -0.24]
lines.SeedType.Radius = 0.3
lines.SeedType.NumberOfPoints = 60
tubes = simple.Tube(Input=lines, Radius=0.008)
picture("streamlines.jpg", tubes, "POINTS", "velocity", "speed", around=bulge)
ratio = bulge.CellData["KneadVolumeRatio"].GetRange()
jacobian = bulge.CellData["KneadScaledJacobian"].GetRange()
stretch = bulge.PointData["KneadStretch"].GetRange()
print(f"volume ratio {ratio}, scaled Jacobian {jacobian}, stretch {stretch}")
