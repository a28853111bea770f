"""Where the small-deflection model ends: the floating frame against the exact beam, over flexibility and spin."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.validation.parallel import check_limits, map_parallel, told
from oblique_impact.validation.small_deflection.errors import (
    DEFLECTIONS,
    MODELS,
    SPINS,
    SmallDeflection,
    points_of,
)


def small_deflection(
    *,
    deflections: Sequence[float] = DEFLECTIONS,
    spins: Sequence[float] = SPINS,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    command: str = "",
    on_progress: OnProgress = silent,
) -> SmallDeflection:
    """Hold the floating frame against the exact beam, over flexibility and spin rate.

    Parameters
    ----------
    deflections : sequence of float
        Nominal deflections over the length, from above 0 to 1.
    spins : sequence of float
        Spin rates in units of sqrt(E I/(rho A L^4)), from 0 to 20.
    out : path, optional
        Folder for report.html, results.json and results.csv; without it nothing is written.
    workers : int, optional
        Parallel processes; default: the cores.
    command : str
        How to repeat the study, for the report.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first problem and after each.

    Returns
    -------
    SmallDeflection
        Errors of all models.

    Raises
    ------
    InputError
        In one line for numbers that are out of range or a folder that cannot be written.
    """
    from oblique_impact.validation.small_deflection.report import write_small_deflection

    check_limits(None, workers, None)
    for name, values, low, high in (("deflections", deflections, 0.0, 1.0), ("spins", spins, -1.0, 20.0)):
        if not values or not all(low < value <= high for value in values):
            shown = ",".join(f"{value:g}" for value in values)
            raise InputError(f"{name} {shown}: should be from {max(low, 0.0):g} to {high:g}")
    # the stop is met at rest: a spin is none of its loads
    cases = [
        (problem, nominal, spin)
        for problem in MODELS
        for nominal in deflections
        for spin in (spins if problem != "stop" else spins[:1])
    ]
    names = [f"{problem}, deflection {nominal:g}, spin {spin:g}" for problem, nominal, spin in cases]
    started = time.perf_counter()
    with nullcontext() if out is None else writing(out) as folder:
        found = map_parallel(points_of, cases, workers, told(on_progress, names))
        points = tuple(point for rows in found for point in rows)
        result = SmallDeflection(points, time.perf_counter() - started)
        return (
            result if folder is None else replace(result, report=write_small_deflection(folder, result, command))
        )


def lines(result: SmallDeflection) -> list[str]:
    """Return what the study found in lines, for a terminal."""
    found = []
    for problem, models in MODELS.items():
        found.append(f"{problem}:")
        for model in models:
            least = min(point.nominal for point in result.of(problem, model))
            worst = max(point.error for point in result.of(problem, model) if point.nominal == least)
            words = (
                f"error {result.coefficient(problem, model):.2g} (w/L)^2, at least {worst:.1e} at the fastest spin"
            )
            found.append(f"  {model:26} {words}")
    return found
