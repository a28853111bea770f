"""What made a report: the command or call, versions, machine; every report shows the same lines."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

from oblique_impact.history.provenance import provenance as made
from oblique_impact.history.provenance import provenance_line, versions

PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray", "matplotlib")


def provenance() -> list[tuple[str, str]]:
    """Return lines (name, value) for the head of every report."""
    numbers = ", ".join(f"{name} {number}" for name, number in _versions().items())
    return [("made by", provenance_line(made())), ("versions", numbers), ("machine", machine())]


def provenance_data() -> dict[str, Any]:
    """Return the same for the JSON of every report."""
    return {"provenance": dict(made()), "versions": _versions(), "machine": machine()}


def _versions() -> dict[str, str]:
    return {"Python": platform.python_version(), **versions(*PACKAGES)}


def machine() -> str:
    """Return processor, number of cores and system; nothing that names the machine itself."""
    return f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"
