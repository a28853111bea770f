"""The SHA-256 digest at the end of a history's file, checked before HDF5 reads it.

HDF5 has no checksum of a whole file, and one with a single sector lost can keep it busy for ever.  It reads no
further than the end of file that its superblock tells, so a line may stand behind that: the file stays one file,
which is renamed, copied and sent together with its digest.  A program that changes the file cuts the line off.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Final

#: with which an HDF5 file begins
_SIGNATURE: Final = b"\x89HDF\r\n\x1a\n"
#: where the superblock tells the end of file, by its version (HDF5 File Format Specification 3.0, section II.A)
_END: Final = {0: 40, 1: 44, 2: 28, 3: 28}
_BLOCK = 1 << 20


def digest_line(content: bytes | memoryview) -> bytes:
    """Return the line that is put behind the content of an HDF5 file."""
    return _line(hashlib.sha256(content).hexdigest())


def _line(digest: str) -> bytes:
    return f"\nSHA-256 of all bytes before this line break: {digest}\n".encode("ascii")


def has_digest(file: Path) -> bool:
    """Whether a file has the digest of its content; one that another program has written has none.

    Raises ValueError if bytes of it are changed or missing, OSError if it cannot be read.
    """
    size, digest = file.stat().st_size, hashlib.sha256()
    with file.open("rb") as opened:
        head = opened.read(64)
        if not head.startswith(_SIGNATURE):
            raise ValueError("it does not begin as a file of HDF5 does")
        place = _END.get(head[len(_SIGNATURE)], len(head))
        if int.from_bytes(head[place : place + 8], "little") == size:
            return False
        opened.seek(0)
        left = size - len(_line(digest.hexdigest()))
        while left > 0 and (block := opened.read(min(left, _BLOCK))):
            digest.update(block)
            left -= len(block)
        if opened.read() != _line(digest.hexdigest()):
            raise ValueError("its bytes are not those that were saved: damaged, or not complete")
    return True
