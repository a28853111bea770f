"""Cross-sections of a beam that stretches, shears and bends: stiffnesses and inertias over its arc length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]
#: values at places x (m), of the shape of x
Profile = Callable[[Array], Array]

#: Poisson's ratio of the material: a scenario knows Young's modulus only; that of aluminium
POISSONS_RATIO = 0.33
#: shear over axial stiffness of sections that hardly shear; more would only cost digits
_SHEAR_RIGID = 30.0


def shear_correction(poissons_ratio: float = POISSONS_RATIO) -> float:
    """Shear correction factor of a solid circular section, 6 (1 + nu)/(7 + 6 nu) (Cowper 1966, Table 1)."""
    return 6.0 * (1.0 + poissons_ratio) / (7.0 + 6.0 * poissons_ratio)


@dataclass(frozen=True)
class ElasticSections:
    """Stiffnesses and inertias per length, each a function of x (m); SI units."""

    axial: Profile  # E A, N
    shear: Profile  # kappa G A, N
    bending: Profile  # E I, N m^2
    mass: Profile  # rho A, kg/m
    rotary: Profile  # rho I, kg m

    @classmethod
    def uniform(
        cls, axial: float, shear: float, bending: float, mass: float, rotary: float = 0.0
    ) -> ElasticSections:
        """Return sections that are the same everywhere."""
        return cls(*(_constant(value) for value in (axial, shear, bending, mass, rotary)))

    @classmethod
    def of(cls, scenario: Scenario, poissons_ratio: float = POISSONS_RATIO) -> ElasticSections:
        """Read the beam of a scenario; G = E/(2 (1 + nu)), kappa as :func:`shear_correction`."""
        sections, modulus = Sections.from_scenario(scenario), scenario.beam.youngs_modulus
        ratio = shear_correction(poissons_ratio) / (2.0 * (1.0 + poissons_ratio))
        return cls(
            axial=lambda x: modulus * sections.area(x),
            shear=lambda x: ratio * modulus * sections.area(x),
            bending=sections.bending_stiffness,
            mass=sections.mass_per_length,
            rotary=lambda x: sections.density * sections.second_moment(x),
        )

    @classmethod
    def bernoulli_euler(cls, scenario: Scenario) -> ElasticSections:
        """Return sections that hardly shear and have no rotary inertia, as in the floating frame; they stretch."""
        own = cls.of(scenario)
        return replace(own, shear=lambda x: _SHEAR_RIGID * own.axial(x), rotary=_constant(0.0))

    def slender(self, factor: float) -> ElasticSections:
        """Return sections of the same E I and rho A whose radius of gyration is `factor` times as large."""
        square = factor**2
        return replace(
            self,
            axial=lambda x: self.axial(x) / square,
            shear=lambda x: self.shear(x) / square,
            rotary=lambda x: square * self.rotary(x),
        )


def _constant(value: float) -> Profile:
    return lambda x: np.full(np.shape(x), value, dtype=float)
