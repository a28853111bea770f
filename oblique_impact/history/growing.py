"""Arrays that grow at their ends while a run goes on, without being copied."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

#: part by which the memory grows beyond what is needed at the moment
_SPARE = 0.25

#: rows of any kind of number
Column = np.ndarray[Any, Any]


class Columns:
    """Named arrays (rows, ...) that have the same number of rows, and more and more of them.

    Nothing here counts the rows: whoever is interrupted while he puts some puts them again.
    """

    def __init__(self) -> None:
        self._arrays: dict[str, Column] = {}

    def put(self, start: int, rows: Mapping[str, Column]) -> None:
        """Write `rows` from row `start` on; views that were taken before are void."""
        for name, its in rows.items():
            array = self._arrays.setdefault(name, np.empty((0, *its.shape[1:]), its.dtype))
            stop = start + len(its)
            if stop > len(array):
                # large arrays are moved by the system, page by page, without a copy
                array.resize((stop + int(_SPARE * stop), *its.shape[1:]), refcheck=False)
            array[start:stop] = its

    def view(self, count: int) -> dict[str, Column]:
        """Return views of the first `count` rows; they hold until more are put."""
        return {name: array[:count] for name, array in self._arrays.items()}

    def take_out(self, count: int) -> dict[str, Column]:
        """Return the first `count` rows and leave nothing; the memory to spare is given back."""
        arrays, self._arrays = self._arrays, {}
        for array in arrays.values():
            array.resize((count, *array.shape[1:]), refcheck=False)
        return arrays
