"""Files that appear whole or not at all, in folders that are known to be writable and have one writer."""

from __future__ import annotations

import errno
import io
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from glob import escape
from pathlib import Path
from secrets import token_hex
from typing import Any, Self

from filelock import FileLock, Timeout

from oblique_impact.errors import InputError
from oblique_impact.interrupts import hold_interrupts

#: bytes; a file of text is read up to this size
MAX_TEXT = 16_000_000
#: random bytes in the name of a temporary file
_TOKEN = 4


def prepare_folder(folder: str | os.PathLike[str]) -> Path:
    """Create `folder` before any work is done; raises InputError with one line if it cannot be written."""
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            return target
    except (OSError, ValueError) as error:
        raise cannot_write(target, error) from None


def cannot_write(target: Path, error: Exception) -> InputError:
    """Return the one line for a folder or file given by --out that cannot be written."""
    return InputError(f"--out {target}: cannot be written: {getattr(error, 'strerror', None) or error}")


def read_text(path: Path, limit: int = MAX_TEXT) -> str:
    """Read UTF-8 text; raises OSError, or ValueError in words for other content or more than `limit` bytes."""
    with path.open("rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise ValueError(f"larger than {limit} bytes")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError("not a text in UTF-8") from None


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Let `write` fill a temporary file beside `path`, of the same suffix, then rename it; raises OSError."""
    write_all({path: write})


def write_all(writers: Mapping[Path, Callable[[Path], Any]]) -> None:
    """Let each of `writers` fill a temporary file beside its path; when all are complete, rename them.

    What fails, on a full disk for instance, fails before the first old file is replaced.  Raises OSError.
    """
    with ExitStack() as cleanup:
        temporaries = {path: _temporary(path, token_hex(_TOKEN)) for path in writers}
        for path, write in writers.items():
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, f"{path.name} is a folder")
            cleanup.callback(temporaries[path].unlink, missing_ok=True)
            write(temporaries[path])
        for path, temporary in temporaries.items():
            os.replace(temporary, path)


def _temporary(path: Path, token: str) -> Path:
    return path.with_name(f".{path.stem}.{token}.part{path.suffix}")


def remove_leftovers(paths: Iterable[Path]) -> None:
    """Remove temporary files of these paths, which killed processes left: only their one writer may do that."""
    for path in paths:
        pattern = _temporary(Path(escape(path.name)), "[0-9a-f]" * (2 * _TOKEN)).name
        for left in path.parent.glob(pattern):
            with suppress(OSError):
                left.unlink()


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, whole or not at all."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


@contextmanager
def writing(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Prepare a folder and be its only writer while the block runs; raises InputError with one line."""
    target = prepare_folder(folder)
    with only_writer(target):
        yield target


@contextmanager
def only_writer(target: str | os.PathLike[str]) -> Iterator[None]:
    """Be the only process that writes to a folder, or to a file that need not exist yet.

    The lock is an empty hidden file, `.lock` in a folder and `.NAME.lock` beside a file, which is gone at the end;
    that of a process that is killed does not block anybody.  Raises InputError, in one line, if another process
    is writing there or the lock cannot be made.
    """
    path = Path(target)
    lock = FileLock(path / ".lock" if path.is_dir() else path.with_name(f".{path.name}.lock"))
    try:
        lock.acquire(timeout=0.1, poll_interval=0.01)  # again, if the holder removes the file meanwhile
    except Timeout:
        line = f"--out {path}: another process is writing here; wait for it, or choose another place"
        raise InputError(line) from None
    except OSError as error:
        raise cannot_write(path, error) from None
    if not path.is_dir():
        remove_leftovers([path])
    try:
        yield
    finally:
        # removed while it is held: filelock does not accept a lock on a file that has lost its name
        with suppress(OSError):
            os.unlink(lock.lock_file)
        lock.release()


class CheckedFile(io.FileIO):
    """A new binary file for HDF5 whose first failed write is raised at the end of the block, as OSError.

    After a failed write, on a full disk for instance, HDF5 tries again until the process ends, and then crashes.
    So every write is reported to HDF5 as done, and after the first failure nothing more is written.  An interrupt
    in a write would crash it too: it is held until a check, or the end of the block.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.problem: OSError | None = None
        self._held = ExitStack()

    def __enter__(self) -> Self:
        """Hold interrupts."""
        super().__enter__()
        self._let_come = self._held.enter_context(hold_interrupts(patient=True))
        return self

    def check(self) -> None:
        """Raise the OSError of the first write that failed, if any, or let an interrupt come."""
        if self.problem:
            raise self.problem
        self._let_come()

    def write(self, data: Any) -> int:
        """Write all of `data`, or remember why not."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while done < len(view) and not self.problem:
                done += super().write(view[done:]) or 0
        except OSError as error:
            self.problem = error
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Set the size, or remember why not."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.problem = self.problem or error
            return size or 0

    def __exit__(self, *error: Any) -> None:
        """Close; HDF5 may have failed over what is missing, but the reason is the first failed write."""
        with self._held:
            super().__exit__(*error)
            if self.problem and (error[0] is None or issubclass(error[0], (OSError, RuntimeError))):
                raise self.problem
