"""The call `reproduce`, behind the command `oblique-impact reproduce`."""

from __future__ import annotations

import os
from pathlib import Path

from oblique_impact.files import prepare_folder
from oblique_impact.progress import OnProgress, silent
from oblique_impact.validation.paper.report import write_report
from oblique_impact.validation.paper.reproduction import Reproduction, compute

#: s of one core that the runs and figures take on a fast machine
SECONDS = 200.0


def reproduce(
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    on_progress: OnProgress = silent,
    command: str = "",
) -> Reproduction:
    """Run the paper's cases and judge its claims.

    Parameters
    ----------
    out : path, optional
        Folder for report.html, results.json, claims.csv, sensitivity.csv and, in figures/, figures 2 to 16; without
        it nothing is drawn or written.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.
    command : str, optional
        How to repeat it, for the report.

    Returns
    -------
    Reproduction
        Claims with their verdicts, and the runs that they are judged by.

    Raises
    ------
    InputError
        In one line, before anything runs, if the folder cannot be written.

    Examples
    --------
    >>> from oblique_impact.validation import reproduce
    >>> result = reproduce(out="out/reproduce")  # doctest: +SKIP
    >>> result.verdicts  # doctest: +SKIP
    {'reproduced': 19, 'partly': 9, 'not reproduced': 3}
    """
    folder = None if out is None else prepare_folder(out)
    result = compute(workers, on_progress)
    if folder is not None:
        write_report(result, folder, command)
    return result


def lines(result: Reproduction, out: Path) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    shown = [f"  {judged.verdict:15s} {judged.claim.id}" for judged in result.claims]
    same = f"{result.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    return [*shown, f"{len(result.claims)} claims: {verdicts}; {same}; report: {out / 'report.html'}"]
