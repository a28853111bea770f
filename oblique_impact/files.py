"""Atomic writing of files, and folders with a single writer."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from oblique_impact.errors import InputError

#: bytes; text files of the program have a thousandth of it: a larger file is of another kind, given by mistake
MAX_TEXT = 16_000_000


def prepare_folder(folder: str | os.PathLike[str]) -> Path:
    """Create `folder` and check that it can be written; raises InputError with one line if not."""
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            return target
    except (OSError, ValueError) as error:
        raise cannot_write(target, error) from None


def cannot_write(target: Path, error: Exception) -> InputError:
    """Return the error of a folder or file given by --out that cannot be written."""
    return InputError(f"--out {target}: cannot be written: {getattr(error, 'strerror', None) or error}")


def read_text(path: Path, limit: int = MAX_TEXT) -> str:
    """Read UTF-8 text; raises OSError, or ValueError for other content or more than `limit` bytes."""
    if path.stat().st_size > limit:
        raise ValueError(f"larger than {limit} bytes")
    try:
        return path.read_text(encoding="utf-8-sig")  # spreadsheets and editors may mark it
    except UnicodeDecodeError:
        raise ValueError("not a text in UTF-8") from None


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Write a file atomically: `write` fills a temporary file beside it, which is renamed.  Raises OSError."""
    write_all({path: write})


def write_all(writers: Mapping[Path, Callable[[Path], Any]]) -> None:
    """Write files together: each of `writers` fills a temporary file; all are renamed when the last is complete.

    Temporary files of a killed process are overwritten, as they have the same names.  Raises OSError.
    """
    temporary = {path: path.with_name(f".{path.stem}.part{path.suffix}") for path in writers}
    try:
        for path, write in writers.items():
            write(temporary[path])
        for path, part in temporary.items():
            os.replace(part, path)
    finally:
        for part in temporary.values():
            part.unlink(missing_ok=True)


def save_whole(path: Path, write: Callable[[Path], Any]) -> Path:
    """Write a file by `write`, whole or not at all, in a folder that is created; returns the file.

    Raises InputError if it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, write)
    except OSError as error:
        raise cannot_write(path, error) from None
    return path


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text atomically; raises OSError."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def plain(data: Any) -> Any:
    """Return data as JSON holds it: fields of objects, rows of frames, paths as text, NaN and infinity as null."""
    if hasattr(data, "model_dump"):  # a scenario
        return data.model_dump(mode="json")
    if hasattr(data, "iterrows"):
        data = data.to_dict("records")
    if is_dataclass(data):
        data = vars(data)
    if isinstance(data, Mapping):
        return {str(name): plain(value) for name, value in data.items() if not callable(value)}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    data = data.item() if hasattr(data, "item") else data  # a number of NumPy
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return str(data) if isinstance(data, os.PathLike) else data


@contextmanager
def writing(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Create a folder and lock it against other processes while the block runs.

    The lock is a hidden file in it, which ends with the process.  Raises InputError if another process is writing
    there or the folder cannot be written.
    """
    target = prepare_folder(folder)
    lock = FileLock(target / ".lock")
    try:
        lock.acquire(timeout=0.1)
    except Timeout:
        line = f"--out {target}: another process is writing here; wait for it, or choose another place"
        raise InputError(line) from None
    except OSError as error:
        raise cannot_write(target, error) from None
    try:
        yield target
    finally:
        Path(lock.lock_file).unlink(missing_ok=True)
        lock.release()
