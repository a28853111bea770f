"""The paper's beam on a peg: a contact whose place slides along the beam."""

from __future__ import annotations

from dataclasses import replace

from oblique_impact.beam.axis import Peg, smooth_shapes
from oblique_impact.beam.floating_frame import BeamModel, PegOnAxis
from oblique_impact.marching.loop import Run
from oblique_impact.marching.records import Record
from oblique_impact.modal.eigenfunctions import Eigenfunctions
from oblique_impact.problem import beam_of, beam_problem
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import Measurement, checks_of
from oblique_impact.validation.reference_values import VALUES, source

check = checks_of("pegs", "Contact with a peg")

MODES = 4
_BEAM = ("discretization.frame=mean-axis", f"discretization.modes={MODES}", "end_time=0.45")
#: some units of the last digit of the references; an energy adds up the errors of all steps
_TIME, _IMPULSE, _ENERGY = 2e-9, 1e-9, 3e-9


def strike(*keys: str) -> tuple[Record, float]:
    """Let the beam fall onto a point at (0.5, 0), without the slope; the record and the energy left (J)."""
    scenario = Scenario.builtin("paper", [*_BEAM, *keys])
    beam, functions = beam_of(scenario), Eigenfunctions("hinged-free", MODES, scenario.beam.length)
    shapes = smooth_shapes(lambda x: functions.derivative(x, 0), scenario.beam.length, float(functions.roots[-1]))
    peg = PegOnAxis(Peg(0.5, 0.0, distance=0.0, lever=0.0, side=1.0), shapes, radius=0.0)
    assert isinstance(beam.model, BeamModel)
    problem = replace(beam_problem(beam), system=beam.model._replace(obstacle=peg))
    record, size = Run(problem).execute(), beam.size
    last = record.segments[-1].states[-1]
    energies = beam.energies(last[None, :size], last[None, size : 2 * size])
    return record, float(sum(part[0] for part in energies))


@check("A beam falls onto a rigid peg, without and with friction.", seconds=1.5)
def rigid() -> list[Measurement]:
    """Times, impulses of impacts and energy."""
    found = []
    for name, keys in (
        ("frictionless", ("contact.friction=frictionless",)),
        ("friction", ("contact.mu_static=0.3", "contact.mu_kinetic=0.3")),
    ):
        record, energy = strike(*keys)
        wanted, text = VALUES[f"peg-{name}"], source(f"peg-{name}")
        impacts = [event for event in record.events if event.kind.value == "impact"]
        found += [
            Measurement(f"{e.kind.value}, {name}", e.time, time, "s", _TIME, text, f"{name}-{k}")
            for k, (e, time) in enumerate(zip(record.events, wanted["times"], strict=True), start=1)
        ]
        for k, (event, (impulse, loss)) in enumerate(zip(impacts, wanted["impacts"], strict=True), start=1):
            found += [
                Measurement(
                    f"impulse {k}, {name}", event.normal_impulse, impulse, "N s", _IMPULSE, text, f"{name}-P{k}"
                ),
                Measurement(f"loss {k}, {name}", event.energy_loss, loss, "J", _ENERGY, text, f"{name}-loss{k}"),
            ]
        found.append(
            Measurement(f"energy, {name}", energy, wanted["energy"], "J", _ENERGY, text, f"{name}-energy")
        )
    return found


@check("A beam falls onto an elastic peg of 10⁶ N/m, without friction.", seconds=1.0)
def elastic() -> list[Measurement]:
    """Times and impulses of the contacts, the largest force."""
    record, _ = strike(
        "contact.friction=frictionless", "contact.normal=spring", "contact.residual_flexibility=false"
    )
    wanted, text, found = VALUES["peg-elastic"], source("peg-elastic"), []
    for k, (contact, (start, end, impulse)) in enumerate(
        zip(record.contacts, wanted["contacts"], strict=True), start=1
    ):
        found += [
            Measurement(f"start {k}", contact.start, start, "s", _TIME, text, f"start-{k}"),
            Measurement(f"end {k}", contact.end, end, "s", _TIME, text, f"end-{k}"),
            Measurement(
                f"impulse {k}", contact.normal_impulse, impulse, "N s", 2.0 * _IMPULSE, text, f"impulse-{k}"
            ),
        ]
    peak = max(contact.peak_force for contact in record.contacts)
    # the dense output of the reference is good to 1e-5 N
    return [*found, Measurement("largest force", peak, wanted["peak"], "N", 5e-5, text, "peak")]
