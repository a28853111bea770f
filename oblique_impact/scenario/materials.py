"""Materials by name: density, Young's modulus and yield strength, nominal values at room temperature.

The yield strength is that of the mildest common grade or temper: beyond it a beam may stay bent.
"""

from __future__ import annotations

from typing import NamedTuple


class Material(NamedTuple):
    """An elastic material."""

    density: float  # kg/m^3
    youngs_modulus: float  # Pa
    yield_strength: float  # Pa, at 0.2 or 0.5 % where it is not seen
    source: str


#: properties of a material, by their keys in [beam]
MATERIAL_PROPERTIES = ("density", "youngs_modulus")
MATERIALS = {
    "steel": Material(
        7850.0,
        210e9,
        235e6,
        "EN 1993-1-1:2005, 3.2.6 (modulus) and table 3.1, S235; EN 1993-1-2:2005, 3.2.2 (density)",
    ),
    "stainless-steel": Material(
        7900.0, 200e9, 210e6, "EN 10088-1:2014, annex E, grade 1.4301; EN 10088-2:2014 (plate, 0.2 %)"
    ),
    "aluminium": Material(2700.0, 70e9, 240e6, "EN 1999-1-1:2007, 3.2.5 and table 3.2b, EN AW-6061 T6"),
    "titanium": Material(
        4430.0,
        110e9,
        827e6,
        "MIL-HDBK-5J (2003), table 5.4.1.0, Ti-6Al-4V, annealed: 0.160 lb/in^3, 16.0e6 and 120e3 psi",
    ),
    "brass": Material(
        8530.0,
        110e9,
        76e6,
        "Copper Development Association, alloy C26000, annealed: 0.308 lb/in^3, 16.0e6 and 11e3 psi",
    ),
    "copper": Material(
        8910.0,
        117e9,
        69e6,
        "Copper Development Association, alloy C11000, annealed: 0.322 lb/in^3, 17.0e6 and 10e3 psi",
    ),
}
