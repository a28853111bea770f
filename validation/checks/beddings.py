"""A beam that lies on a table or on a bed, at rest and after a blow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import brentq

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.runs import FRICTIONLESS, run_exact

check = checks_of("beddings", "A beam on a table or a bed")

_NODES = "discretization.method=fem", "discretization.modes=0", FRICTIONLESS, "initial.angle=0"


#: a place at the first third of a cell of the one is at that of a cell of the other
_GRIDS = (16, 64)


def _order(errors: Sequence[float] | np.ndarray) -> float:
    """Order of two errors, the second of four times as fine a grid."""
    return float(np.log(abs(errors[0] / errors[1])) / np.log(4.0))


def _bending(scenario: Scenario) -> float:
    """E I (N m^2) of a uniform beam."""
    return float(Sections.from_scenario(scenario).bending_stiffness(0.0))


def _pushes(*keys: str, case: str, grid: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Let a beam come to rest; returns its places (m) and the forces on them (N)."""
    mesh = f"contact.grid={grid}", f"discretization.elements={grid}"
    steps = f"solver.contact_step={step}", f"solver.free_step={step}", "solver.output_interval=1e-2"
    history = simulate(Scenario.builtin(case, [*_NODES, *mesh, *steps, *keys]))
    return history["contact_place"].values[-1], history["contact_lambda_n"].values[-1]


@check("A heavy beam lies on a table that is lower than its pin.", seconds=1.0)
def lifted() -> Iterator[Measurement]:
    """Force of the table, w (L - a/2) with the free length a = (24 EI d/w)^(1/4), and its moment about the pin."""
    free, soft, forces = 19.0 / 48.0, "beam.youngs_modulus=7e8", []
    plain = Scenario.builtin("slap", [soft])
    weight = Sections.from_scenario(plain).mass * plain.gravity  # of a beam of 1 m
    depth = weight * free**4 / (24.0 * _bending(plain))
    for grid in _GRIDS:
        keys = soft, "beam.mass_proportional=60", "end_time=0.6"
        table = f"obstacles=[{{kind='side', origin=[0.0, {-depth}]}}]"
        places, pushes = _pushes(*keys, table, case="slap", grid=grid, step=2e-4)
        forces.append(float(pushes.sum()) / weight)
    wanted, text = 1.0 - 0.5 * free, "a beam without moment and slope where it lies down"
    yield Measurement("force over the weight, 64 places", forces[-1], wanted, "1", 1e-4, text, "force")
    order = _order(np.array(forces) - wanted)
    yield Measurement("order in the grid", order, 2.0, "1", 0.3, "the place is known to a cell", "order")
    moment = float(pushes @ places) / weight
    # arms shrink by the foreshortening
    yield Measurement("moment over that of the weight", 2.0 * moment, 1.0, "1", 1e-5, "equilibrium", "moment")


@check(
    "A torque at the pin presses a beam without weight, in a gap between two tables, onto the upper one.",
    seconds=0.6,
)
def pressed() -> Iterator[Measurement]:
    """The beam lies flat beyond c, T c^2 = 6 EI h; there the table pushes with T/c, and nowhere else."""
    torque, place, forces = 2.0, 31.0 / 48.0, []
    height = torque * place**2 / (6.0 * _bending(Scenario.builtin("gap")))
    for grid in _GRIDS:
        gap = f"obstacles.1.origin=[0.0, {-height}]", f"obstacles.2.origin=[0.0, {height}]"
        hub = "root.kind=hub", "root.inertia=1e-3", f"root.torque={torque}", "initial.angular_velocity=0"
        keys = "gravity=0", "beam.mass_proportional=100", "end_time=0.4", "solver.scheme=time-stepping"
        places, pushes = _pushes(*gap, *hub, *keys, case="gap", grid=grid, step=1e-4)
        forces.append(float(pushes.sum()) * place / torque)
    text = "a beam without moment and slope where it lies down"
    yield Measurement("force over T/c, 64 places", forces[-1], 1.0, "1", 2e-4, text, "force")
    yield Measurement("order in the grid", _order(np.array(forces) - 1.0), 2.0, "1", 0.3, text, "order")
    farthest = float(np.max(np.abs(places[pushes > 1e-6 * torque] - place)))
    yield Measurement("distance of pushes from c", farthest, 0.0, "m", 1.0 / 64, "the cell of c", "places")


@check("A torque at its pin presses a beam without weight onto a bed, which does not hold it back.", seconds=1.5)
def lifts_off() -> Iterator[Measurement]:
    """It lifts off at l, tan(alpha l) = -tanh(alpha l) with alpha^4 = b/4EI, and is straight beyond.

    With Krylov's functions, from l on backwards: the deflection is (theta/alpha) F2, F2 = 0 at the pin, the torque
    4 EI alpha theta F4 and the force of the bed 4 EI alpha^2 theta F3.
    """
    z, torque, length = float(brentq(lambda z: np.tan(z) + np.tanh(z), 2.0, 3.0)), 10.0, 0.6
    alpha = z / length
    F3 = 0.5 * np.sinh(z) * np.sin(z)
    F4 = 0.25 * (np.cosh(z) * np.sin(z) - np.sinh(z) * np.cos(z))
    bedding = 4.0 * _bending(Scenario.builtin("paper")) * alpha**4
    bed = f"obstacles=[{{kind='side', bedding={bedding}}}]"
    where = "contact.where=anywhere", "contact.normal=spring", "contact.damping=4", "slope.enabled=false"
    hub = "root.kind=hub", "root.inertia=1e-3", f"root.torque={-torque}", "gravity=0"
    wanted, errors = torque * alpha * F3 / F4, []
    for grid in (8, 32):
        keys = "end_time=0.3", "beam.kelvin_voigt=1e-2"
        places, pushes = _pushes(*where, *hub, bed, *keys, case="paper", grid=grid, step=2e-4)
        errors.append(float(pushes.sum()) / wanted - 1.0)
    text = "a beam on springs that only push (Hetenyi 1946, Krylov's functions)"
    last = float(places[pushes > 0.0].max())
    quantity, moment = "force of the bed over the exact one, 32 places", float(pushes @ places) / torque
    yield Measurement(quantity, errors[-1] + 1.0, 1.0, "1", 4e-3, text, "force")
    yield Measurement("order in the grid", _order(errors), 2.0, "1", 0.1, "trapezoidal rule", "order")
    yield Measurement("last place that bears", last, length, "m", 1.0 / 32, text, "lift-off")
    yield Measurement("moment over the torque", moment, 1.0, "1", 1e-5, "equilibrium", "moment")


def _struck(*keys: str, grid: int, exact: bool = False) -> np.ndarray:
    """Let a beam fall onto a bed that ends at 0.75 m; impulse (N s), begin and end (s) of its contact."""
    fall = "initial.angle=0", "initial.angular_velocity=-0.2", "end_time=0.03", "beam.kelvin_voigt=1e-5"
    where = "contact.where=anywhere", "contact.normal=spring", FRICTIONLESS, "slope.enabled=false"
    bed = "obstacles=[{kind='side', origin=[0.0, -0.001], bedding=1e5, extent=[0.0, 0.75]}]"
    more = "discretization.frame=mean-axis", "solver.output_interval=1e-3", f"contact.grid={grid}"
    scenario = Scenario.builtin("paper", [*fall, *where, bed, *more, *keys])
    contacts = (run_exact if exact else simulate)(scenario).contacts
    impulse = sum(contact.normal_impulse for contact in contacts)
    return np.array([impulse, min(c.start for c in contacts), max(c.end for c in contacts)])


@check("A beam falls onto a bed that ends under it, in ever finer grids.", seconds=3.0)
def grids() -> Iterator[Measurement]:
    """Order of the impulse and of the end of the contact in the grid."""
    found = np.array([_struck("discretization.modes=16", grid=grid) for grid in (8, 16, 32, 64)])
    steps = np.diff(found, axis=0)
    for k, name in ((0, "impulse"), (2, "end")):
        order = float(np.log2(steps[-2, k] / steps[-1, k]))
        yield Measurement(f"order in the grid, {name}", order, 2.0, "1", 0.15, "trapezoidal rule", name)


@check("The exact beam against modes on a bed that ends under them.", seconds=12.0)
def exact() -> Iterator[Measurement]:
    """Order in the elements, then impulse and times; of the same grid."""

    def fine(elements: int, grid: int, step: float) -> np.ndarray:
        steps = f"solver.free_step={step}", f"solver.contact_step={step}"
        mesh = "discretization.method=absolute", f"discretization.elements={elements}"
        return _struck(*mesh, *steps, grid=grid, exact=True)

    modes, text = _struck("discretization.modes=24", grid=16), "24 modes, which share nothing with this beam"
    found = fine(16, 16, 1e-5)
    yield within("impulse", found[0], modes[0], "N s", 5e-6, text, "impulse")
    yield Measurement("begin", found[1], modes[1], "s", 3e-8, text, "begin")
    yield Measurement("end", found[2], modes[2], "s", 1e-7, text, "end")
    coarse, middle, finer = (fine(count, 4, 4e-5)[0] for count in (8, 16, 32))
    order = float(np.log2(abs((middle - coarse) / (finer - middle))))
    yield Measurement("order in the elements, impulse", order, 4.0, "1", 0.3, "nodes converge like h⁴", "elements")
