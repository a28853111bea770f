"""Materials by name: density and Young's modulus, nominal values at room temperature with their sources."""

from __future__ import annotations

from typing import NamedTuple


class Material(NamedTuple):
    """An elastic material."""

    density: float  # kg/m^3
    youngs_modulus: float  # Pa
    source: str


#: properties of a material, by their keys in [beam]
MATERIAL_PROPERTIES = ("density", "youngs_modulus")
MATERIALS = {
    "steel": Material(7850.0, 210e9, "EN 1993-1-1:2005, 3.2.6 (modulus); EN 1993-1-2:2005, 3.2.2 (density)"),
    "stainless-steel": Material(7900.0, 200e9, "EN 10088-1:2014, annex E, grade 1.4301"),
    "aluminium": Material(2700.0, 70e9, "EN 1999-1-1:2007, 3.2.5"),
    "titanium": Material(4430.0, 110e9, "MIL-HDBK-5J (2003), table 5.4.1.0, Ti-6Al-4V: 0.160 lb/in^3, 16.0e6 psi"),
    "brass": Material(8530.0, 110e9, "Copper Development Association, alloy C26000: 0.308 lb/in^3, 16.0e6 psi"),
    "copper": Material(8910.0, 117e9, "Copper Development Association, alloy C11000: 0.322 lb/in^3, 17.0e6 psi"),
}
