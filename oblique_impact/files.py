"""Atomic writing of files, and folders with a single writer."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import is_dataclass
from functools import partial
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from oblique_impact.errors import InputError

#: bytes; text files of the program have a thousandth of it: a larger file is of another kind, given by mistake
MAX_TEXT = 16_000_000


def prepare_folder(folder: str | os.PathLike[str], option: str = "--out ") -> Path:
    """Create `folder` and check that it can be written; raises InputError with one line if not."""
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            return target
    except (OSError, ValueError) as error:
        raise cannot_write(target, error, option) from None


def suffix_of(file: Path) -> str:
    """Return the suffix of a file's name in small letters, ".xdmf"; "" of a name such as v1.5."""
    return file.suffix.lower() if file.suffix[1:2].isalpha() else ""


def cannot_write(target: Path, error: Exception, option: str = "--out ") -> InputError:
    """Return the error of a folder or file, given by `option`, that cannot be written."""
    return InputError(f"{option}{target}: cannot be written: {getattr(error, 'strerror', None) or error}")


def read_text(path: Path, limit: int = MAX_TEXT) -> str:
    """Read UTF-8 text; raises OSError, or ValueError for other content or more than `limit` bytes."""
    if path.stat().st_size > limit:
        raise ValueError(f"larger than {limit} bytes")
    try:
        return path.read_text(encoding="utf-8-sig")  # spreadsheets and editors may mark it
    except UnicodeDecodeError:
        raise ValueError("not a text in UTF-8") from None


def write_all(writers: Mapping[Path, Callable[[Path], Any]]) -> None:
    """Write files together: each of `writers` fills a temporary file; all are renamed when the last is complete.

    A file is on the disk before it gets its name, and its name before the next one: a crash at any moment leaves
    whole files, the first ones new and the others old.  Temporary files of a killed process are overwritten, as
    they have the same names.  Raises OSError.
    """
    temporary = {path: path.with_name(f".{path.stem}.part{path.suffix}") for path in writers}
    try:
        for path, write in writers.items():
            write(temporary[path])
            with temporary[path].open("rb+") as file:
                os.fsync(file.fileno())
        for path, part in temporary.items():
            os.replace(part, path)
            _sync_names(path.parent)
    finally:
        for part in temporary.values():
            part.unlink(missing_ok=True)


def _sync_names(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system can: Windows and some network disks cannot."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def save_whole(path: Path, write: Callable[[Path], Any], option: str = "--out ") -> Path:
    """Write a file by `write`, whole or not at all, in a folder that is created; returns the file.

    Raises InputError, which begins with `option`, if it cannot be written or another process is writing it.
    """
    with writing_file(path, option):
        try:
            write_all({path: write})
        except OSError as error:
            raise cannot_write(path, error, option) from None
    return path


def save_all(folder: Path, contents: Mapping[str, bytes | str]) -> None:
    """Write files into a folder that is created, all of them or none; they get their names in this order.

    Raises InputError if they cannot be written.
    """

    def writer(content: bytes | str) -> Callable[[Path], Any]:
        return partial(Path.write_bytes, data=content.encode() if isinstance(content, str) else content)

    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_all({folder / name: writer(content) for name, content in contents.items()})
    except OSError as error:
        raise cannot_write(folder, error) from None


def save_text(path: Path, text: str, option: str = "--out ") -> Path:
    """Write UTF-8 text as `save_whole` does."""
    return save_whole(path, lambda part: part.write_text(text, encoding="utf-8"), option)


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
def writing(folder: str | os.PathLike[str] | None) -> Iterator[None]:
    """Create a folder, if one is given, and keep other processes from writing into it while the block runs.

    Raises InputError at once if another process is writing there or the folder cannot be written.
    """
    if folder is None:
        yield
    else:
        target = prepare_folder(folder)
        with _locked(target / ".lock", f"--out {target}"):
            yield


@contextmanager
def writing_file(file: str | os.PathLike[str], option: str = "--out ") -> Iterator[None]:
    """Create the folder of a file, and keep other processes from writing that file while the block runs.

    Raises InputError as `writing` does; its message begins with `option`.
    """
    target = Path(file)
    prepare_folder(target.parent, option)
    with _locked(target.with_name(f".{target.name}.lock"), f"{option}{target}"):
        yield


@contextmanager
def _locked(path: Path, place: str) -> Iterator[None]:
    """Hold a lock, a hidden file that ends with the process; a block in a block of the same lock holds it too."""
    lock = FileLock(path, is_singleton=True)
    outermost = not lock.is_locked
    try:
        lock.acquire(timeout=0.1)
    except Timeout:
        line = f"{place}: another process is writing here; wait for it, or choose another place"
        raise InputError(line) from None
    except OSError as error:
        raise InputError(f"{place}: cannot be written: {error.strerror or error}") from None
    try:
        yield
    finally:
        if outermost:
            with suppress(OSError):  # Windows keeps a file that is open
                path.unlink()
        lock.release()
