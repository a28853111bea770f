"""Run by ParaView's own Python: what its readers and filters make of an export, as JSON on standard output.

Arguments: the file, the name of the reader, numbers of frames.
"""

import json
import sys

from paraview import servermanager, simple

REFERENCE, CONTACT_POINT = 2, 4
FORCES = ("contact_force", "normal_force", "friction_force")


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
        "cells": [mesh.GetCellType(k) for k in range(mesh.GetNumberOfCells())],
        "owners": sorted({int(row[0]) for row in tuples(cell.GetArray("part"))}),
        "arrays": {point.GetArrayName(k): tuples(point.GetArray(k)) for k in range(point.GetNumberOfArrays())},
    }


def fetched(proxy, time):
    proxy.UpdatePipeline(time)
    return leaves(servermanager.Fetch(proxy))


def of_part(source, number):
    """The part of this number as a user takes it out: Threshold by the cell array `part`."""
    chosen = simple.Threshold(Input=source, Scalars=["CELLS", "part"], ThresholdMethod="Between")
    chosen.LowerThreshold = chosen.UpperThreshold = number
    return chosen


def points_of(meshes):
    return [mesh.GetPoint(k) for mesh in meshes for k in range(mesh.GetNumberOfPoints())]


def lines_along(source, name, time):
    """End points of the lines that Glyph draws for a vector, 1 m for 1000 N."""
    glyph = simple.Glyph(Input=source, GlyphType="Line", GlyphMode="All Points", ScaleFactor=1e-3)
    glyph.OrientationArray = glyph.ScaleArray = ["POINTS", name]
    return points_of(fetched(glyph, time))


def main(file, reader, *frames):
    key = "FileNames" if reader == "XDMFReader" else "FileName"
    source = getattr(simple, reader)(**{key: file})
    source.UpdatePipelineInformation()
    times = list(source.TimestepValues)
    found = {"times": times, "frames": []}
    for frame in map(int, frames):
        time = times[frame] if times else 0.0
        meshes = [content(mesh) for mesh in fetched(source, time)]
        warped = simple.WarpByVector(Input=of_part(source, REFERENCE), Vectors=["POINTS", "displacement"])
        at_contact = of_part(source, CONTACT_POINT)
        found["frames"].append(
            {
                "meshes": meshes,
                "warped": points_of(fetched(warped, time)),
                "glyphs": {name: lines_along(at_contact, name, time) for name in FORCES},
            }
        )
    print(json.dumps(found))


main(*sys.argv[1:])
