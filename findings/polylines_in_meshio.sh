#!/usr/bin/env bash
# meshio reads one polyline of five points in four ways: not at all, as no cell, as a "line" of five nodes.
#
# Guess before: meshio has no polyline, so that it either refuses such a file or takes its pieces for lines of two
# nodes, in all formats alike; a mesh of lines and a polyline is refused too.
#
# Seen (meshio 5.3.5): VTK's format 3.0 ends the process; format 5.1 and VTU give a mesh without the polyline, a warning
# printed beside it, so that of a file with lines as well a part is left; XDMF gives a block "line" with five nodes in a
# row, where `meshio.CellBlock` of that type has two, its numbers floating-point without NumberType; "l 1 2 3 4 5" of an
# OBJ file is left out without a word.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6 h5py==3.16.0
cd "$folder"
points="0 0 0 1 0 0 2 0 0 3 0 0 4 0 0"
grid="DATASET UNSTRUCTURED_GRID
POINTS 5 double
$points"
printf '%s\n' "# vtk DataFile Version 3.0" old ASCII "$grid" "CELLS 1 6" "5 0 1 2 3 4" "CELL_TYPES 1" 4 > old.vtk
printf '%s\n' "# vtk DataFile Version 5.1" new ASCII "$grid" "CELLS 2 5" "OFFSETS vtktypeint64" "0 5" \
    "CONNECTIVITY vtktypeint64" "0 1 2 3 4" "CELL_TYPES 1" 4 > new.vtk
cat > mixed.vtu <<XML
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="5" NumberOfCells="3">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">$points</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 1 2 2 3 4</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">2 4 7</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">3 3 4</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
XML
cat > line.xdmf <<XML
<Xdmf Version="2.0"><Domain><Grid Name="line" GridType="Uniform">
<Topology TopologyType="Polyline" NodesPerElement="5" NumberOfElements="1">
<DataItem Dimensions="1 5" Format="XML">0 1 2 3 4</DataItem></Topology>
<Geometry GeometryType="XYZ"><DataItem Dimensions="5 3" Format="XML">$points</DataItem></Geometry></Grid></Domain></Xdmf>
XML
printf 'v %s 0 0\n' 0 1 2 3 4 > line.obj
echo "l 1 2 3 4 5" >> line.obj
"$folder/venv/bin/python" - <<'PY'
import contextlib
import io

import meshio

print(f"meshio {meshio.__version__}")
for name, expected, words in (
    ("old.vtk", "the process ends", True),
    ("new.vtk", [], True),
    ("mixed.vtu", [("line", [[0, 1], [1, 2]])], True),
    ("line.xdmf", [("line", [[0.0, 1.0, 2.0, 3.0, 4.0]])], False),
    ("line.obj", [], False),
):
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            found = [(block.type, block.data.tolist()) for block in meshio.read(name).cells]
        except SystemExit:
            found = "the process ends"
    print(f"{name}: {found}{', with words' if said.getvalue() else ', without a word'}")
    assert (found, bool(said.getvalue())) == (expected, words), f"was {expected}"
PY
