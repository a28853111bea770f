"""Metadata of pictures: what made them, and the warnings of their runs; `exiftool` shows them as the comment."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from oblique_impact.history.history import History
from oblique_impact.history.provenance import described, provenance

#: key of the text in the metadata of a figure, by suffix; the other formats have none
_KEYS = {".png": "Comment", ".pdf": "Subject", ".svg": "Description"}
_XMP_FLAG = 0x04  # of the header of an extended WebP file
_XMP = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
    '<rdf:Description xmlns:dc="http://purl.org/dc/elements/1.1/" dc:description="{}"/></rdf:RDF></x:xmpmeta>'
)


def made_by(histories: Iterable[History] = ()) -> str:
    """Return what made the histories, if any are drawn, and what draws them where that is something else."""
    drawing = described(provenance())
    runs = list(dict.fromkeys(described(history.summary.get("provenance", {})) for history in histories))
    if runs in ([], [drawing]):
        return drawing
    return "; ".join([*runs, f"drawn by {drawing}"])


def warnings_of(histories: Iterable[History]) -> list[str]:
    """Return the warnings of the runs that are drawn, each once."""
    return list(dict.fromkeys(text for history in histories for text in history.summary.get("warnings", ())))


def comment(histories: Iterable[History] = (), factor: float = 1.0) -> str:
    """Return what made a picture, by how much it magnifies deflections, and the warnings of its runs."""
    runs = list(histories)
    magnified = [f"deflection drawn ×{factor:g}"] if factor != 1.0 else []
    return "; ".join([made_by(runs), *magnified, *(f"warning: {text}" for text in warnings_of(runs))])


def figure_metadata(file: Path, text: str) -> dict[str, str] | None:
    """Return the `metadata` of Matplotlib's `savefig` for a file; None where it takes none."""
    key = _KEYS.get(file.suffix.lower())
    return {key: text} if key else None


def save_picture(picture: Image.Image, file: Path, dpi: float, text: str) -> None:
    """Save a picture as PNG with a text; raises OSError."""
    info = PngInfo()
    info.add_itxt("Comment", text)
    picture.save(file, dpi=(dpi, dpi), pnginfo=info)


def add_comment(file: Path, text: str) -> None:
    """Add a text to a GIF or WebP file, for which the encoder has no option; raises OSError."""
    content = file.read_bytes()
    if content[:3] == b"GIF":
        file.write_bytes(_with_gif_comment(content, text))
    elif content[:4] == b"RIFF" and content[12:16] == b"VP8X":
        file.write_bytes(_with_xmp(content, text))


def _with_gif_comment(content: bytes, text: str) -> bytes:
    """Return a GIF file with a comment, blocks of up to 255 bytes, before its first frame (GIF89a, section 24)."""
    colours = 3 * 2 ** ((content[10] & 7) + 1) if content[10] & 0x80 else 0  # the table behind the header
    data = text.encode("ascii", "replace")
    blocks = b"".join(bytes([len(part)]) + part for part in (data[k : k + 255] for k in range(0, len(data), 255)))
    return content[: 13 + colours] + b"\x21\xfe" + blocks + b"\x00" + content[13 + colours :]


def _with_xmp(content: bytes, text: str) -> bytes:
    """Return a WebP file with a description in XMP, which is its last chunk (RFC 9649, section 2.7)."""
    safe = text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    data = _XMP.format(safe).encode("utf-8")
    chunk = b"XMP " + struct.pack("<I", len(data)) + data + b"\x00" * (len(data) % 2)
    flags = bytes([content[20] | _XMP_FLAG])
    size = struct.pack("<I", len(content) + len(chunk) - 8)
    return content[:4] + size + content[8:20] + flags + content[21:] + chunk
