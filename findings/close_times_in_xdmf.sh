#!/usr/bin/env bash
# VTK's reader of XDMF 2 (PyVista's, ParaView's "XDMF Reader") shows frames at close times over each other, and how
# close they may be depends on where between powers of two they lie.
#
# Guess before: frames at different double precision times are different frames; if there is a tolerance it is
# absolute, one spacing of doubles below 2 (2.2e-16), so that 4.4e-16 apart is apart everywhere.
#
# Seen (VTK 9.7.2): up to 2.2e-16 apart both frames are shown at both times.  4.4e-16 apart they are single below 2,
# not so between 2 and 4: at one of the two times, the later or the earlier by the last digit of the time, both are
# shown.  From 4 on neighbouring doubles are single.  8.9e-16 apart frames are single below 4 as well.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check vtk==9.7.2
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import math

from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

FRAME = """<Grid Name="frame" GridType="Collection" CollectionType="Spatial"><Time Value="{time!r}"/>
<Grid Name="line" GridType="Uniform">
<Topology TopologyType="Polyline" NodesPerElement="2" NumberOfElements="1">
<DataItem Dimensions="1 2" Format="XML">0 1</DataItem></Topology>
<Geometry GeometryType="XYZ"><DataItem Dimensions="2 3" Format="XML">{x} 0 0 {x} 1 0</DataItem></Geometry>
</Grid></Grid>"""
SERIES = """<?xml version="1.0"?><Xdmf Version="2.0"><Domain>
<Grid Name="series" GridType="Collection" CollectionType="Temporal">{frames}</Grid></Domain></Xdmf>"""


def meshes(data):
    if not data.IsA("vtkMultiBlockDataSet"):
        return [data]
    return [mesh for k in range(data.GetNumberOfBlocks()) if data.GetBlock(k) for mesh in meshes(data.GetBlock(k))]


def shown(times):
    """For each time the places of the frames that are shown there; frame k lies at x = k."""
    with open("series.xdmf", "w") as file:
        file.write(SERIES.format(frames="".join(FRAME.format(time=t, x=k) for k, t in enumerate(times))))
    reader = vtkXdmfReader()
    reader.SetFileName("series.xdmf")
    reader.UpdateInformation()
    offered = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert list(offered) == times
    found = []
    for time in offered:
        reader.UpdateTimeStep(time)
        found.append([round(mesh.GetPoint(0)[0]) for mesh in meshes(reader.GetOutput())])
    return found


def after(time, doubles):
    for _ in range(doubles):
        time = math.nextafter(time, math.inf)
    return time


print(f"VTK {vtkVersion().GetVTKVersion()}")
BOTH, SINGLE = [[0, 1], [0, 1]], [[0], [1]]
for start, doubles, expected in (
    (0.5, 2, BOTH),
    (1.5, 1, BOTH),
    (1.5, 2, SINGLE),
    (2.3, 1, [[0], [0, 1]]),
    (3.9, 1, [[0, 1], [1]]),
    (2.3, 2, SINGLE),
    (3.9, 2, SINGLE),
    (4.0, 1, SINGLE),
    (100.0, 1, SINGLE),
):
    times = [start, after(start, doubles)]
    found = shown(times)
    print(f"two frames from t = {start}, {times[1] - times[0]:.2g} apart: shown at each of the times {found}")
    assert found == expected, f"was {expected}"
PY
