"""A Python state beside an export: one command opens the coloured beam in ParaView, with its force as an arrow.

`paraview --script=NAME.paraview.py` shows it and is ready to play; `pvpython NAME.paraview.py PICTURE.png TIME`
saves the picture of a time (s).  Names of functions and properties are those of `paraview.simple` since 5.10.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oblique_impact.renders.exports.scene import Scene
from oblique_impact.renders.story import colour_scale

#: what opens a format in ParaView
_READERS = {"pvd": "PVDReader", "xdmf": "Xdmf3ReaderS", "vtkhdf": "VTKHDFReader"}
#: length of the arrow of the largest force, over that of the beam
_ARROW = 0.16
#: samples between two whose places are seen
_EVERY = 50
_TEXT = '''\
"""Open the export beside this file in ParaView: bending stress in colours, the contact force as an arrow.

    paraview --script=FILE                 (FILE is this file)
    pvpython FILE PICTURE.png TIME         (saves the picture of a time in s)
"""

import os
import sys

from paraview.simple import *

try:
    folder = os.path.dirname(os.path.abspath(__file__))
except NameError:  # pasted into the Python shell of ParaView
    folder = {folder!r}
reader = {reader}(FileName=os.path.join(folder, {name!r}))
view = GetActiveViewOrCreate("RenderView")
view.Background = [1.0, 1.0, 1.0]
view.UseColorPaletteForBackground = 0
view.OrientationAxesVisibility = 0


def part(number):
    """Return one part of the export by its number, see the array `parts` of the field data."""
    return Threshold(Input=reader, Scalars=["CELLS", "part"], LowerThreshold=number, UpperThreshold=number)


surface = part({surface})
beam = Show(surface, view)
ColorBy(beam, ("POINTS", "bending_stress"))
colours = GetColorTransferFunction("bending_stress")
colours.ApplyPreset("Cool to Warm", True)
colours.RescaleTransferFunction({low!r}, {high!r})  # Pa, of the whole run
legend = GetScalarBar(colours, view)
legend.Title, legend.ComponentTitle = "bending stress (Pa)", ""
legend.TitleColor = legend.LabelColor = [0.0, 0.0, 0.0]
legend.Orientation, legend.WindowLocation, legend.ScalarBarLength = "Horizontal", "Lower Center", 0.35
legend.TitleFontSize, legend.LabelFontSize = 14, 12
legend.AutomaticLabelFormat, legend.LabelFormat, legend.RangeLabelFormat = 0, "%-#.3g", "%-#.3g"
beam.SetScalarBarVisibility(view, True)
for number in {still}:  # pin and slope
    solid = Show(part(number), view)
    ColorBy(solid, None)
    solid.AmbientColor = solid.DiffuseColor = [0.62, 0.65, 0.68]
{arrow}
time = Show(AnnotateTimeFilter(Input=reader, Format="t = {{time:.5f}} s"), view)
time.Color, time.FontSize = [0.0, 0.0, 0.0], 14
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToFirst()
view.CameraParallelProjection = 1
view.CameraFocalPoint = {focus!r}
view.CameraPosition = {eye!r}
view.CameraViewUp = [0.0, 1.0, 0.0]
view.CameraParallelScale = {scale!r}
pictures = [word for word in sys.argv[1:] if word.endswith(".png")]
if pictures:
    view.ViewSize = [1280, 720]
    scene.AnimationTime = float(sys.argv[-1])
    SaveScreenshot(pictures[0], view, ImageResolution=[1280, 720])
else:
    Render(view)
'''
_FORCE = """\
arrow = Glyph(Input=part({contact}), GlyphType="Arrow")
arrow.OrientationArray = ["POINTS", "contact_force"]
arrow.ScaleArray = ["POINTS", "contact_force"]
arrow.ScaleFactor = {factor!r}  # m for 1 N
arrow.GlyphMode = "All Points"
force = Show(arrow, view)
ColorBy(force, None)
force.AmbientColor = force.DiffuseColor = [0.84, 0.37, 0.05]"""


def state_file(target: Path) -> Path:
    """Return the place of the state beside an export."""
    return target.with_suffix(".paraview.py")


def state_text(scene: Scene, target: Path, format: str) -> str:
    """Return the Python state that opens the export `target` of a format."""
    numbers = {part.name: number for number, part in enumerate(scene.parts)}
    geometry = scene.geometry
    limit = colour_scale([geometry], "bending_stress").limit
    length = geometry.scenario.root.hub_radius + geometry.scenario.beam.length
    peak = geometry.peak_force
    places = np.concatenate([geometry.centreline(k)[:, :2] for k in range(0, geometry.times.size, _EVERY)])
    low, high = np.minimum(places.min(axis=0), -0.1 * length), np.maximum(places.max(axis=0), 0.1 * length)
    x, y = (0.5 * (low + high)).tolist()
    scale = 0.6 * float(max(high[1] - low[1], (high[0] - low[0]) * 720 / 1280))
    arrow = ""
    if "contact_point" in numbers and peak > 0.0:
        arrow = _FORCE.format(contact=numbers["contact_point"], factor=_ARROW * length / peak)
    return _TEXT.format(
        name=target.name,
        folder=str(target.parent.resolve()),
        reader=_READERS[format],
        surface=numbers["surface"],
        low=-limit,
        high=limit,
        still=[numbers[name] for name in ("pin", "slope") if name in numbers],
        arrow=arrow,
        focus=[x, y, 0.0],
        eye=[x + 0.6 * length, y + 0.9 * length, 3.0 * length],
        scale=scale,
    )
