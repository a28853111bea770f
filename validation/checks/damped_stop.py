"""A rigid stop under a beam with internal damping: convergence to the limit, in three discretizations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import gamma, hyp1f1

from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.checks.rigid_impact import BENDING, MASS, SPEED, TURNING
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FRICTIONLESS, MEAN_AXIS, run

check = checks_of("damped-stop", "A rigid stop under a damped beam")

LIMIT = VALUES["damped-stop"]
_MODES = ("beam.kelvin_voigt=1e-5", FRICTIONLESS, MEAN_AXIS, "solver.output_interval=1e-3")
_MASSLESS = (*_MODES, "contact.point_inertia=none")
_ELEMENTS = (
    'discretization={method="fem", elements=64, modes=0}',
    "solver={free_step=2.5e-6, contact_step=5e-7}",
    "beam.kelvin_voigt=1e-5",
    FRICTIONLESS,
)


def exact_impulse(t: float, viscosity: float) -> float:
    """Impulse (N s) on the end of a damped beam that a rigid stop holds from t = 0 on at the speed v0.

    lambda(s) = Z v0 s^(-1/2) (1 + eta s)^(1/4) in the Laplace domain, Z = (E I)^(1/4) m^(3/4)/sqrt 2; its
    integral is I(t) = Z v0 (eta t)^(1/4)/Gamma(5/4) 1F1(-1/4; 5/4; -t/eta) until waves come back from the pin.
    """
    impedance = BENDING**0.25 * MASS**0.75 / np.sqrt(2.0)
    return float(impedance * SPEED * (viscosity * t) ** 0.25 / gamma(1.25) * hyp1f1(-0.25, 1.25, -t / viscosity))


@check("The end of a damped beam meets a rigid stop: its impulse until the first wave is back.", seconds=2.0)
def short_time_impulse() -> Iterator[Measurement]:
    """Twenty modes and 64 elements without inertia at the end, eta = 1e-4 s, 1e-5 to 6e-4 s after the touch."""
    viscosity = 1e-4
    text = "closed form, I = Z v0 (eta t)^(1/4)/Gamma(5/4) 1F1(-1/4; 5/4; -t/eta), Z = (EI)^(1/4) m^(3/4)/sqrt 2"
    nodal = (
        "discretization.method=fem",
        "discretization.modes=0",
        "discretization.elements=64",
        "solver.free_step=1e-6",
        "solver.contact_step=2e-7",
    )
    for name, model, accuracies in (
        ("20 modes", ("discretization.modes=20",), (2e-3, 2e-5, 1e-4)),
        ("64 elements", nodal, (2e-3, 5e-4, 4e-5)),
    ):
        for t, allowed in zip((1e-5, 1e-4, 6e-4), accuracies, strict=True):
            changes = (f"beam.kelvin_voigt={viscosity}", f"end_time={t}")
            (contact,) = run("paper", *_MASSLESS, *TURNING, *model, *changes).contacts
            quantity, tail = f"impulse after {1e6 * t:g} us, {name}", f"{name.split()[1]}-{1e6 * t:g}us"
            exact = exact_impulse(t, viscosity)
            yield within(quantity, contact.normal_impulse, exact, "N s", allowed, text, tail)


@check("The paper's beam with 1e-5 s of damping on a rigid stop: sixteen modes without inertia.", seconds=2.0)
def sixteen_modes() -> list[Measurement]:
    """Five contacts, impulse, end and start of the next collision; no energy is lost in impacts."""
    history, text = run("paper", *_MASSLESS, "discretization.modes=16", "end_time=0.66"), source("damped-stop")
    first, second = history.macro_collisions
    energy = history.summary["energy"]
    return [
        Measurement("contacts of the first collision", first["contacts"], 5, "1", 0.0, text, "contacts"),
        Measurement("end of the first collision", first["end"], LIMIT["end"], "s", 1e-5, text, "end"),
        Measurement("impulse", first["normal_impulse"], LIMIT["impulse"], "N s", 2e-5, text, "impulse"),
        Measurement(
            "start of the second collision", second["start"], LIMIT["starts"][1], "s", 5e-6, text, "second"
        ),
        Measurement("energy lost in impacts", energy["lost_impact"], 0.0, "J", 0.0, "no inertia, no impact"),
        Measurement("energy not accounted for", energy["unaccounted"], 0.0, "J", 2e-11, "balance", "unaccounted"),
    ]


@check(
    "Three ways to one limit: plastic impacts on elements, no inertia on modes, a stiff spring on modes.",
    seconds=40.0,
)
def three_ways() -> Iterator[Measurement]:
    """Each against the limit: impulse and energy of the first collision, starts of the next three."""
    text = source("damped-stop")
    spring = ("contact.normal=spring", "contact.stiffness=1e11")
    ways: dict[str, tuple[tuple[str, ...], tuple[float, ...]]] = {
        "plastic impacts": (_ELEMENTS, (1e-6, 2e-6, 4e-5)),
        "no inertia": ((*_MASSLESS, "discretization.modes=24"), (1e-6, 4e-6, 6e-5)),
        "stiff spring": ((*_MODES, *spring, "discretization.modes=24"), (1e-6, 2e-6, 4e-5)),
    }
    for name, (keys, of_starts) in ways.items():
        history, tail = simulate(Scenario.builtin("paper", [*keys, "end_time=1.0"])), name.replace(" ", "-")
        first, *later = history.macro_collisions
        impulse, exact = first["normal_impulse"], LIMIT["impulse"]
        yield Measurement(f"impulse, {name}", impulse, exact, "N s", 5e-6, text, f"impulse-{tail}")
        energy, exact = float(history.total_energy.sel(time=LIMIT["after"], method="nearest")), LIMIT["energy"]
        yield Measurement(f"energy after, {name}", energy, exact, "J", 5e-6, text, f"energy-{tail}")
        for number, (collision, allowed) in enumerate(zip(later, of_starts, strict=True), start=2):
            quantity, exact = f"start of collision {number}, {name}", LIMIT["starts"][number - 1]
            start = f"start-{number}-{tail}"
            yield Measurement(quantity, collision["start"], exact, "s", allowed, text, start)
