"""The folder of a sweep: one writer, one fingerprint, finished rows, histories.  Every file is whole or absent."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer, prepare_folder, read_text, write_text
from oblique_impact.validation.journal import Journal
from oblique_impact.validation.measuring import Done, Files
from oblique_impact.validation.sweeps.plan import Plan

TABLE, ROWS = "results.parquet", "rows.jsonl"
_FINGERPRINT, _HISTORIES, _SCRATCH = "fingerprint.json", "histories", ".scratch"


class Store:
    """Finished runs of a sweep on disk; use `open_store`.

    Attributes
    ----------
    folder, table : Path
        Of the sweep, and its Parquet file.
    scratch : str
        Folder for temporary files of the processes that run.
    journal : Journal or None
        The rows until the table is written.
    """

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder, self.table, self._scratch = folder, folder / TABLE, folder / _SCRATCH
        self.scratch = str(self._scratch)
        try:
            self._prepare(plan)
        except OSError as error:
            raise cannot_write(folder, error) from None
        names = [q.name for q in plan.quantities]
        whole = self.table.is_file()
        self.journal = None if whole else Journal(folder / ROWS, plan.fingerprint, plan.design.size, names)
        self.done = set(range(plan.design.size)) if self.journal is None else self.journal.done

    def add(self, done: Done) -> None:
        """Keep a finished run: its history, if there is one, and its row."""
        assert self.journal is not None, "the table is written"
        try:
            if done.files is not None:
                self._keep_history(done.row["run"], done.files)
        except OSError as error:
            raise cannot_write(self.folder, error) from None
        self.journal.add(done.row)

    def _prepare(self, plan: Plan) -> None:
        """Check the fingerprint, leave it with the resolved sweep if there is none, remove what a kill left."""
        for name in (ROWS, _HISTORIES, _SCRATCH, TABLE):
            if (self.folder / name).is_symlink():
                raise InputError(
                    f"--out {self.folder}: {name} leads elsewhere; a sweep writes into its folder only"
                )
        self._check_fingerprint(plan)
        for leftover in self.folder.glob(".*.part*"):
            leftover.unlink(missing_ok=True)
        shutil.rmtree(self._scratch, ignore_errors=True)
        write_text(self.folder / "scenario.toml", plan.base.to_toml())
        write_text(self.folder / "sweep.toml", plan.to_toml())
        self._scratch.mkdir()

    def _check_fingerprint(self, plan: Plan) -> None:
        path, ours = self.folder / _FINGERPRINT, plan.fingerprint
        if path.exists():
            try:
                theirs = str(json.loads(read_text(path))["fingerprint"])
            except (ValueError, KeyError, TypeError, RecursionError):
                theirs = "damaged"
            if theirs != ours:
                raise InputError(
                    f"--out {self.folder}: holds another sweep (fingerprint {theirs}, this one has {ours}); "
                    "choose another folder, delete this one, or go on with the sweep.toml that lies in it"
                )
            return
        strangers = [name for name in (TABLE, ROWS, _HISTORIES) if (self.folder / name).exists()]
        if strangers:
            raise InputError(f"--out {self.folder}: holds {strangers[0]} of something else; choose another folder")
        write_text(path, json.dumps({"fingerprint": ours, "runs": plan.design.size}) + "\n")

    def _keep_history(self, run: int, files: Files) -> None:
        final = self.folder / _HISTORIES / f"{run + 1:06d}"
        partial = self._scratch / final.name
        for old in (partial, final):
            shutil.rmtree(old, ignore_errors=True)
        partial.mkdir()
        final.parent.mkdir(exist_ok=True)
        for name, content in files.items():
            (partial / name).write_bytes(content)
        os.replace(partial, final)


@contextmanager
def open_store(folder: str | os.PathLike[str], plan: Plan) -> Iterator[Store]:
    """Open the folder of a sweep for writing, for this process alone.

    Raises InputError if it cannot be written, is in use, or holds another sweep.
    """
    target = prepare_folder(folder)
    with only_writer(target):
        store = Store(target, plan)
        try:
            yield store
        finally:
            shutil.rmtree(store.scratch, ignore_errors=True)
