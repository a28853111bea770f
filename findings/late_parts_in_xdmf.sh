#!/usr/bin/env bash
# VTK's reader of XDMF 2 offers times out of order where a part begins before the one that stands first in the file.
#
# Guess before: the times of a file are the union of those of its collections, ascending, as VTK's pipeline has its time
# steps; a part is shown from its first frame on.
#
# Seen (VTK 9.7.2): parts are shown from their first frame on, but the times are listed as the file has them: of a first
# collection at 1, 2 and a second one at 0, 1, 2 they are 1, 2, 0.  Whoever takes the first for the beginning and
# the last for the end, or looks for a time by bisection, has neither.  With the collections the other way round they
# are 0, 1, 2.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check vtk==9.7.2
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

LINE = """<Grid Name="{name}{time:g}" GridType="Uniform"><Time Value="{time!r}"/>
<Topology TopologyType="Polyline" NodesPerElement="2" NumberOfElements="1">
<DataItem Dimensions="1 2" Format="XML">0 1</DataItem></Topology>
<Geometry GeometryType="XYZ"><DataItem Dimensions="2 3" Format="XML">{time} 0 0 {time} 1 0</DataItem></Geometry>
</Grid>"""
SERIES = """<Grid Name="{name}" GridType="Collection" CollectionType="Temporal">{lines}</Grid>"""


def read(parts):
    """The times of a file and the number of parts that are shown at each."""
    series = [
        SERIES.format(name=name, lines="".join(LINE.format(name=name, time=time) for time in times))
        for name, times in parts.items()
    ]
    file = "-".join(parts) + ".xdmf"
    with open(file, "w") as out:
        out.write(f'<?xml version="1.0"?><Xdmf Version="2.0"><Domain>{"".join(series)}</Domain></Xdmf>')
    reader = vtkXdmfReader()
    reader.SetFileName(file)
    reader.UpdateInformation()
    times = list(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    counts = []
    for time in times:
        reader.UpdateTimeStep(time)
        data = reader.GetOutput()
        blocks = [data.GetBlock(k) for k in range(data.GetNumberOfBlocks())] if hasattr(data, "GetBlock") else [data]
        counts.append(sum(block is not None and block.GetNumberOfPoints() > 0 for block in blocks))
    return times, counts


print(f"VTK {vtkVersion().GetVTKVersion()}")
late, whole = [1.0, 2.0], [0.0, 1.0, 2.0]
for parts, expected in (
    ({"late": late, "whole": whole}, ([1.0, 2.0, 0.0], [2, 2, 1])),
    ({"whole": whole, "late": late}, ([0.0, 1.0, 2.0], [1, 2, 2])),
):
    found = read(parts)
    print(f"collections {parts}: times {found[0]}, parts shown {found[1]}")
    assert found == expected, f"was {expected}"
PY
