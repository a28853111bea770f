"""Run by ParaView's own Python: what its readers make of an export, as JSON on standard output.

Arguments: the file, the name of the reader, numbers of frames.
"""

import json
import sys

from paraview import servermanager, simple


def leaves(data):
    """Meshes of a composite, however deep."""
    if data.IsA("vtkMultiPieceDataSet"):
        pieces = [data.GetPiece(k) for k in range(data.GetNumberOfPieces())]
    elif data.IsA("vtkMultiBlockDataSet"):
        pieces = [data.GetBlock(k) for k in range(data.GetNumberOfBlocks())]
    else:
        return [data]
    return [mesh for piece in pieces if piece is not None for mesh in leaves(piece)]


def tuples(array):
    return [array.GetTuple(k) for k in range(array.GetNumberOfTuples())]


def content(mesh):
    point, cell = mesh.GetPointData(), mesh.GetCellData()
    return {
        "points": [mesh.GetPoint(k) for k in range(mesh.GetNumberOfPoints())],
        "owners": sorted({int(row[0]) for row in tuples(cell.GetArray("part"))}),
        "arrays": {point.GetArrayName(k): tuples(point.GetArray(k)) for k in range(point.GetNumberOfArrays())},
    }


file, reader, *frames = sys.argv[1:]
source = getattr(simple, reader)(**{"FileNames" if reader == "XDMFReader" else "FileName": file})
source.UpdatePipelineInformation()
times = list(source.TimestepValues)
found = []
for frame in map(int, frames):
    source.UpdatePipeline(times[frame] if times else 0.0)
    found.append([content(mesh) for mesh in leaves(servermanager.Fetch(source))])
print(json.dumps({"times": times, "frames": found}))
