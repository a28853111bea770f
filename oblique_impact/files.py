"""Files that appear whole or not at all, in folders that are known to be writable and have one writer."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError

#: bytes; a file of text is read up to this size
MAX_TEXT = 16_000_000

#: what is being written and has no final name yet; removed even when a process leaves in haste
_unfinished: set[Path] = set()


def prepare_folder(folder: str | os.PathLike[str]) -> Path:
    """Create `folder` and make sure that it can be written, before any work is done.

    Raises InputError with one line if not.
    """
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
    """Read UTF-8 text of at most `limit` bytes.

    Raises OSError, or ValueError in words if the file is larger or is not UTF-8.
    """
    with path.open("rb") as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise ValueError(f"larger than {limit} bytes")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError("not a text in UTF-8") from None


def write_whole(path: Path, write: Callable[[Path], Any]) -> None:
    """Let `write` fill a temporary file beside `path`, then put it in place in one step.

    The temporary file keeps the suffix of `path`.  Raises OSError.
    """
    write_all({path: write})


def write_all(writers: Mapping[Path, Callable[[Path], Any]]) -> None:
    """Let each of `writers` fill a temporary file beside its path; when all are complete, put them in place.

    What fails, on a full disk for instance, fails before the first old file is replaced.  Raises OSError.
    """
    with ExitStack() as stack:
        parts = {path: stack.enter_context(_temporary(path)) for path in writers}
        for path, write in writers.items():
            write(parts[path])
        for path, part in parts.items():
            os.replace(part, path)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, whole or not at all."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


@contextmanager
def writing(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Prepare a folder and be its only writer while the block runs.

    Raises InputError with one line if it cannot be written or another process writes there.
    """
    target = prepare_folder(folder)
    with only_writer(target):
        yield target


@contextmanager
def unfinished(*paths: Path) -> Iterator[None]:
    """Name files or folders that are to be removed if the process leaves inside of the block."""
    _unfinished.update(paths)
    try:
        yield
    finally:
        _unfinished.difference_update(paths)


def discard_unfinished() -> None:
    """Remove what is half-written; for a process that leaves without unwinding."""
    for path in list(_unfinished):
        remove(path)


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all it holds, if it is there; links are not followed."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink(missing_ok=True)


@contextmanager
def only_writer(target: str | os.PathLike[str]) -> Iterator[None]:
    """Be the only process that writes to a folder, or to a file that need not exist yet.

    The lock is an empty hidden file, `.lock` in a folder and `.NAME.lock` beside a file, which is gone at the end.
    The system takes the lock away from a process that is killed; the file that is left then holds nobody up.
    Where a file system knows no locks, there is none.

    Raises
    ------
    InputError
        In one line, if another process is writing there or the lock cannot be made.
    """
    path = Path(target)
    lock = path / ".lock" if path.is_dir() else path.with_name(f".{path.name}.lock")
    handle = _hold(path, lock)
    try:
        with unfinished(lock):
            yield
    finally:
        # removed while it is held: who opened it in the meantime finds another file under its name, or none
        with suppress(OSError):
            lock.unlink(missing_ok=True)
        os.close(handle)


def _hold(path: Path, lock: Path) -> int:
    """Return the open, locked file `lock`."""
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
    while True:
        try:
            handle = os.open(lock, flags, 0o666)
        except OSError as error:
            raise cannot_write(path, error) from None
        if not _try_lock(handle):
            os.close(handle)
            raise InputError(
                f"--out {path}: another process is writing here; wait for it, or choose another place"
            )
        with suppress(OSError):
            # the last holder may have removed the file between our opening and locking it
            if os.path.samestat(os.fstat(handle), os.stat(lock)):
                return handle
        os.close(handle)


def _try_lock(handle: int) -> bool:
    """Lock an open file; False if another process holds it."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True  # this file system knows no locks
    return True


@contextmanager
def _temporary(path: Path) -> Iterator[Path]:
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=f".part{path.suffix}", dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    os.chmod(temporary, 0o666 & ~_umask())
    try:
        with unfinished(temporary):
            yield temporary
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
