"""Rows of a study that are finished, on disk as soon as they are: an interrupted study goes on with the others."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, read_text, write_text
from oblique_impact.history.provenance import source_digest
from oblique_impact.validation.measuring import Row, is_row
from oblique_impact.validation.parallel import SOURCE

#: bytes; the rows of the largest sweep are fewer
_MAX_SIZE = 1_000_000_000


def fingerprint_of(decisive: dict[str, Any]) -> str:
    """Return a hash of all that decides about rows: the same for two studies with the same results.

    Besides `decisive`, which the study knows, that is the source which computes and measures.
    """
    resolved = {**decisive, "source": source_digest(SOURCE)}
    return hashlib.sha256(json.dumps(resolved, sort_keys=True).encode()).hexdigest()[:16]


class Journal:
    """A file that begins with the fingerprint of a study; each line after it is a finished row.

    Parameters
    ----------
    path : Path
        The file; what another study has left there is replaced.
    fingerprint : str
        Of the study.
    runs : int
        How many rows there will be.
    quantities : collection of str
        Names that rows may have values of.

    Raises
    ------
    InputError
        In one line if the file is damaged, leads elsewhere or cannot be written.
    """

    def __init__(self, path: Path, fingerprint: str, runs: int, quantities: Collection[str]) -> None:
        self._path, self._runs, self._quantities = path, runs, quantities
        if path.is_symlink():
            raise InputError(f"--out {path.parent}: {path.name} leads elsewhere; results stay in their folder")
        head = {"fingerprint": fingerprint}
        try:
            if not path.is_file() or self._head() != head:
                write_text(path, json.dumps(head) + "\n")
            elif not (text := read_text(path, _MAX_SIZE)).endswith("\n"):
                write_text(path, text[: text.rindex("\n") + 1])  # a kill may leave half a line
        except OSError as error:
            raise cannot_write(path.parent, error) from None
        except (ValueError, RecursionError):
            raise self._damaged() from None
        self.done = {row["run"] for row in self.rows()}

    def missing(self) -> list[int]:
        """Numbers of the runs that are not done."""
        return [run for run in range(self._runs) if run not in self.done]

    def add(self, row: Row) -> None:
        """Put a row on disk."""
        try:
            with self._path.open("a", encoding="utf-8") as file:
                # Python writes floats so that they come back as they were
                file.write(json.dumps(row) + "\n")
        except OSError as error:
            raise cannot_write(self._path.parent, error) from None
        self.done.add(row["run"])

    def rows(self) -> Iterator[Row]:
        """Read the finished rows, in no particular order."""
        try:
            for line in self._lines()[1:]:
                row = json.loads(line)
                if not is_row(row, self._runs, self._quantities):
                    raise ValueError
                yield row
        except (ValueError, RecursionError):
            raise self._damaged() from None

    def remove(self) -> None:
        """Forget the rows: the study is finished."""
        self._path.unlink(missing_ok=True)

    def _head(self) -> dict[str, Any]:
        head = json.loads(self._lines()[0])
        if not isinstance(head, dict) or head.keys() != {"fingerprint"}:
            raise ValueError
        return head

    def _lines(self) -> list[str]:
        """Whole lines; what a kill has left of another is none."""
        return read_text(self._path, _MAX_SIZE).split("\n")[:-1] or [""]

    def _damaged(self) -> InputError:
        words = f"{self._path.name} is damaged; delete it, and its runs are repeated"
        return InputError(f"--out {self._path.parent}: {words}")
