"""Arrays as base64: what the page carries, and back."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LAST = 32766  # the largest code of a number; one more stands for what lies beyond
_NO_NUMBER = -32768


def packed(values: NDArray[Any], kind: str) -> dict[str, Any]:
    """Return an array as its `type` (f4, f8, i4, u1), `shape` and little-endian `data` as base64.

    What float32 cannot hold becomes infinite, which the page does not draw.
    """
    with np.errstate(over="ignore"):
        data = np.ascontiguousarray(values, dtype=f"<{kind}")
    return {"type": kind, "shape": list(data.shape), "data": base64.b64encode(data.tobytes()).decode("ascii")}


def rounded(values: Array, bound: float) -> dict[str, Any]:
    """Return an array as 16-bit multiples of `scale`, half of which is the rounding error, at half of the size.

    The scale is 1/32766 of the largest magnitude up to `bound`; what lies beyond that becomes infinite.
    """
    size = np.abs(values[np.isfinite(values)])
    scale = float(np.max(size[size <= bound], initial=0.0)) / _LAST or 1.0
    with np.errstate(over="ignore"):
        codes = np.clip(np.rint(values / scale), -_LAST - 1, _LAST + 1)
    return packed(np.where(np.isnan(codes), _NO_NUMBER, codes), "i2") | {"scale": scale}


def unpacked(entry: dict[str, Any]) -> NDArray[Any]:
    """Return an array as the page reads it."""
    codes = np.frombuffer(base64.b64decode(entry["data"]), dtype=f"<{entry['type']}").reshape(entry["shape"])
    if "scale" not in entry:
        return codes
    values = np.where(np.abs(codes.astype(int)) > _LAST, np.copysign(np.inf, codes), entry["scale"] * codes)
    return np.where(codes == _NO_NUMBER, np.nan, values).astype("f4")
