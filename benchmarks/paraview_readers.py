"""What ParaView's readers make of an export: the rows of ParaView in docs/reference/files.md.

By hand, on a machine with ParaView (Debian: paraview, python3-paraview, xvfb):

    oblique-impact run paper --set end_time=0.34 --out out
    oblique-impact export out --format pvd --out out/beam --every 1000
    oblique-impact export out --format xdmf --out out/beam --every 1000
    xvfb-run -a pvpython benchmarks/paraview_readers.py out

It prints a row for each reader.  "left" and "right" are the frames of the first jump, "next" the one after them.
The last two columns are of changed copies: the numbers of parts in the first three frames where `contact_point` is
missing in the first, and jumps of XDMF whose right side is one double after the left one, as it is in a PVD.

Last run: 28 November 2026, ParaView 5.11.0 of Debian 12.
"""

from __future__ import annotations

import itertools
import math
import os
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

from paraview import servermanager, simple

READERS = {
    "PVD Reader": lambda file: simple.PVDReader(FileName=file),
    "XDMF Reader": lambda file: simple.XDMFReader(FileNames=[file]),
    "Xdmf3 Reader S": lambda file: simple.Xdmf3ReaderS(FileName=[file]),
    "Xdmf3 Reader T": lambda file: simple.Xdmf3ReaderT(FileName=[file]),
}
WORDS = "reader, blocks, left, right, middle, between, before, after, late part, one double"
COLUMNS = WORDS.split(", ")


def meshes(data, name=""):
    """Yield (names on the way, mesh) for all meshes of a composite dataset."""
    if data.IsA("vtkMultiBlockDataSet"):
        for k in range(data.GetNumberOfBlocks()):
            own = data.GetMetaData(k).Get(data.NAME()) if data.HasMetaData(k) else None
            if data.GetBlock(k):
                yield from meshes(data.GetBlock(k), own or name)
    elif data.IsA("vtkCompositeDataSet"):
        walk = data.NewIterator()
        walk.InitTraversal()
        while not walk.IsDoneWithTraversal():
            yield from meshes(walk.GetCurrentDataObject(), name)
            walk.GoToNextItem()
    else:
        yield name, data


def look(reader, time):
    """Return names or numbers of the parts that a reader shows at a time (s), and rates of the gap."""
    reader.UpdatePipeline(time)
    found = list(meshes(servermanager.Fetch(reader)))
    blocks = [name or str(int(mesh.GetCellData().GetArray("part").GetValue(0))) for name, mesh in found]
    arrays = [mesh.GetPointData().GetArray("gap_rate") for _, mesh in found]
    return blocks, [array.GetValue(0) for array in arrays if array]


def beside(file, folder, name):
    """Return the place of a copy of an export, with the export's data beside it."""
    for data in (file.with_suffix(".h5"), file.with_suffix("")):
        if data.exists() and not (folder / data.name).exists():
            (folder / data.name).symlink_to(data)
    return folder / f"{name}{file.suffix}"


def without(file, folder):
    """Write a copy without the contact point in the first frame; returns it."""
    tree = ElementTree.parse(file)
    if file.suffix == ".pvd":
        series = tree.find("Collection")
        series.remove(series.find("DataSet[@name='contact_point']"))
    else:
        series = tree.find("Domain/Grid[@Name='contact_point']")
        series.remove(series.find("Grid"))
    copy = beside(file, folder, "late")
    tree.write(copy)
    return copy


def closer(file, folder):
    """Write a copy in which both sides of a jump are neighbouring doubles; returns it."""
    tree = ElementTree.parse(file)
    for grids in tree.findall("Domain/Grid"):
        for before, stamp in itertools.pairwise(grids.findall("Grid/Time")):
            left = float(before.get("Value"))
            if float(stamp.get("Value")) - left < 1e-14:
                stamp.set("Value", repr(math.nextafter(left, math.inf)))
    copy = beside(file, folder, "close")
    tree.write(copy)
    return copy


def opened(name, file):
    """Return a reader of a file and its times (s); Xdmf3 readers end the process for a relative path."""
    reader = READERS[name](str(file))
    reader.UpdatePipelineInformation()
    return reader, list(reader.TimestepValues)


def row(name, file, folder):
    """Return what a reader shows, in words, by columns."""
    reader, times = opened(name, file)
    k = next(k for k, time in enumerate(times) if times[k + 1] - time < 1e-14)
    left, right, following = times[k : k + 3]
    words = {"left": left, "right": right, "next": following, "first": times[0], "last": times[-1]}
    rates = {look(reader, time)[1][0]: word for word, time in words.items()}

    def shown(time, of=reader):
        return " and ".join(rates.get(rate, "another") for rate in look(of, time)[1]) or "none"

    middle = 0.5 * (left + right)
    cells = [name, ", ".join(look(reader, left)[0]), shown(left), shown(right)]
    cells.append(shown(middle) if left < middle < right else "-")
    cells += [shown(time) for time in (0.5 * (right + following), times[0] - 1.0, times[-1] + 1.0)]
    late, stamps = opened(name, without(file, folder))
    cells.append(", ".join(str(len(look(late, time)[0])) for time in stamps[:3]))
    close, stamps = opened(name, closer(file, folder))
    cells.append("; ".join(shown(time, close) for time in stamps[k : k + 2]))
    return cells


def main():
    """Print the table."""
    source = Path(os.path.abspath(sys.argv[1]))
    version = servermanager.vtkSMProxyManager
    print(f"ParaView {version.GetVersionMajor()}.{version.GetVersionMinor()}.{version.GetVersionPatch()}")
    print("| " + " | ".join(COLUMNS) + " |")
    print("| " + " | ".join("---" for _ in COLUMNS) + " |")
    with tempfile.TemporaryDirectory() as folder:
        for name in READERS:
            file = source / ("beam.pvd" if name.startswith("PVD") else "beam.xdmf")
            print("| " + " | ".join(row(name, file, Path(folder))) + " |", flush=True)


if __name__ == "__main__":
    main()
