"""A bar that tells how long what it covers is, in a picture without perspective."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_UNITS = ((0.1, 1.0, "m"), (1e-3, 1e-3, "mm"), (0.0, 1e-6, "µm"))  # from which length on (m), size (m), name


class ScaleBar(NamedTuple):
    """A bar of a length (m), as the picture shows it: from its first end to its last one (2,) (pixels)."""

    length: float
    across: Array

    @property
    def text(self) -> str:
        """The length in words."""
        size, unit = next((size, unit) for least, size, unit in _UNITS if self.length >= 0.999 * least)
        return f"{self.length / size:g} {unit}"


def scale_bar(metre: Array, longest: float) -> ScaleBar:
    """Return the longest bar of 1, 2 or 5 times a power of ten that is not longer than some pixels.

    `metre` (2,) is what the picture makes of a metre along the bar (pixels).
    """
    room = longest / float(np.linalg.norm(metre))
    power = 10.0 ** math.floor(math.log10(room))
    length = float(next(m for m in (5.0, 2.0, 1.0) if m * power <= room * (1.0 + 1e-9)) * power)
    return ScaleBar(length, length * np.asarray(metre))
