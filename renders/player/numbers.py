"""Numbers as the page writes them."""

from __future__ import annotations

import math


def fixed(value: float, decimals: int) -> str:
    """Return a number with fixed decimals and a proper minus, none before zero; a dash if it is not finite."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "−")


def significant(value: float, digits: int) -> str:
    """Return a number with significant digits, without exponent between 1e-4 and 1e6."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    if not -4 <= int(power) <= 5:
        return f"{mantissa}e{int(power)}".replace("-", "−")
    return fixed(value, max(0, digits - 1 - int(power)))
