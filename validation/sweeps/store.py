"""The folder of a sweep: one writer, one fingerprint, finished rows, histories.  Every file is whole or absent."""

from __future__ import annotations

import json
import os
import re
import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer, prepare_folder, read_text, write_text
from validation.sweeps.plan import Plan
from validation.sweeps.work import Done, Files, Row, is_row

TABLE = "results.parquet"
_FINGERPRINT = "fingerprint.json"
_PARTS, _HISTORIES, _SCRATCH = "parts", "histories", ".scratch"

#: s; finished rows wait in memory for so long at most
FLUSH = 0.25
#: so many small files become a large one
_MERGE = 256
_PART = re.compile(r"\d{8,}\.json")
#: bytes; a part with all runs of the largest sweep is smaller
_MAX_PART = 1_000_000_000


class Store:
    """Finished rows of a sweep on disk; use `open_store`."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder, self._plan = folder, plan
        self._pending: list[Row] = []
        self._flushed = time.monotonic()
        with self._writing():
            self._prepare()
        self._small = self._part_files()
        self._next = 1 + max((int(path.stem) for path in self._small), default=0)
        self.done = set(range(plan.design.size)) if self.complete else {row["run"] for row in self.rows()}

    @property
    def complete(self) -> bool:
        """Whether the table is written."""
        return self.table.is_file()

    @property
    def table(self) -> Path:
        """The Parquet file."""
        return self.folder / TABLE

    @property
    def scratch(self) -> str:
        """Folder for temporary files of the processes that run; gone with `close`."""
        folder = self.folder / _SCRATCH
        folder.mkdir(exist_ok=True)
        return str(folder)

    def missing(self) -> list[int]:
        """Numbers of the runs that are not done."""
        return [run for run in range(self._plan.design.size) if run not in self.done]

    def add(self, finished: Sequence[Done]) -> None:
        """Take finished runs; they are on disk a quarter of a second later, histories at once."""
        for row, files in finished:
            if files is not None:
                with self._writing():
                    self._keep_history(row["run"], files)
            self._pending.append(row)
            self.done.add(row["run"])
        if time.monotonic() - self._flushed >= FLUSH:
            self.flush()

    def flush(self) -> None:
        """Put all finished rows on disk."""
        self._flushed = time.monotonic()
        if self._pending:
            with self._writing():
                self._small.append(self._write_part(self._pending))
                self._pending = []
                if len(self._small) >= _MERGE:
                    self._merge()

    def rows(self) -> Iterator[Row]:
        """Read the finished rows on disk, each once, in no particular order."""
        seen: set[int] = set()
        for path in self._part_files():
            for row in self._read_part(path):
                # a kill between the making of a large file and the end of its small ones leaves both
                if row["run"] not in seen:
                    seen.add(row["run"])
                    yield row

    def finish(self) -> None:
        """Forget the parts; the table has it all."""
        shutil.rmtree(self._parts, ignore_errors=True)

    def close(self) -> None:
        """Put what is finished on disk and clean up."""
        try:
            self.flush()
        finally:
            shutil.rmtree(self.folder / _SCRATCH, ignore_errors=True)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Say in one line what the system has against it, a full disk for instance."""
        try:
            yield
        except OSError as error:
            raise cannot_write(self.folder, error) from None

    @property
    def _parts(self) -> Path:
        return self.folder / _PARTS

    def _part_files(self) -> list[Path]:
        return sorted(path for path in self._parts.glob("*.json") if _PART.fullmatch(path.name))

    def _prepare(self) -> None:
        """Check the fingerprint, leave it with the resolved sweep if there is none, remove what a kill left."""
        for name in (_PARTS, _HISTORIES, _SCRATCH, TABLE):
            if (self.folder / name).is_symlink():
                raise InputError(
                    f"--out {self.folder}: {name} leads elsewhere; a sweep writes into its folder only"
                )
        self._check_fingerprint()
        for place in (self.folder, self._parts):
            for leftover in place.glob(".*.part*"):
                leftover.unlink(missing_ok=True)
        shutil.rmtree(self.folder / _SCRATCH, ignore_errors=True)
        write_text(self.folder / "scenario.toml", self._plan.base.to_toml())
        write_text(self.folder / "sweep.toml", self._plan.to_toml())
        if not self.complete:
            self._parts.mkdir(exist_ok=True)

    def _check_fingerprint(self) -> None:
        path = self.folder / _FINGERPRINT
        ours = self._plan.fingerprint
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
        strangers = [name for name in (TABLE, _PARTS, _HISTORIES) if (self.folder / name).exists()]
        if strangers:
            raise InputError(f"--out {self.folder}: holds {strangers[0]} of something else; choose another folder")
        data = {"fingerprint": ours, "runs": self._plan.design.size}
        write_text(path, json.dumps(data) + "\n")

    def _write_part(self, rows: Sequence[Row]) -> Path:
        path = self._parts / f"{self._next:08d}.json"
        # one row a line; Python writes floats so that they come back as they were
        lines = ",\n".join(json.dumps(row) for row in rows)
        write_text(path, f"[\n{lines}\n]\n")
        self._next += 1
        return path

    def _read_part(self, path: Path) -> list[Row]:
        try:
            found: list[Row] = json.loads(read_text(path, _MAX_PART))
            names = {q.name for q in self._plan.quantities}
            if not isinstance(found, list) or not all(is_row(row, self._plan.design.size, names) for row in found):
                raise ValueError
        except (ValueError, RecursionError):
            words = "is damaged; delete it, and its runs are repeated"
            raise InputError(f"--out {self.folder}: {path.relative_to(self.folder)} {words}") from None
        return found

    def _merge(self) -> None:
        rows = [row for path in self._small for row in self._read_part(path)]
        self._write_part(rows)
        for path in self._small:
            path.unlink()
        self._small = []

    def _keep_history(self, run: int, files: Files) -> None:
        final = self.folder / _HISTORIES / f"{run:06d}"
        partial = final.with_name(f".{run:06d}.part")
        for old in (partial, final):
            shutil.rmtree(old, ignore_errors=True)
        try:
            partial.mkdir(parents=True)
            for name, content in files.items():
                (partial / name).write_bytes(content)
            os.replace(partial, final)
        finally:
            shutil.rmtree(partial, ignore_errors=True)


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
            store.close()
