"""Costs of the program as ratios: the table of docs/speed.md.

    python benchmarks/bench.py [TURNS]      some minutes; keeps docs/speed.csv

Both sides of a ratio take turns, and processor time is what counts, so that other work on the machine affects both
alike; the median of the turns' ratios is kept.  Work over precision is measured by `work_precision.py`.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from oblique_impact.machine import THREADS

os.environ.update(dict.fromkeys(THREADS, "1"))  # before anything loads NumPy

import work_precision
from films import film_costs
from measuring import (
    OLD,
    march_cost,
    median_ratio,
    old_program,
    print_table,
    printed,
    process_cost,
    size_on_disk,
    write_csv,
)
from peers import mujoco_chain
from peers.problems import CHEAPEST, LIMITS, SCENARIOS

from oblique_impact import Scenario, simulate
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.validation import sweep
from oblique_impact.validation.studies.design import make_plan

STORE = Path(__file__).parents[1] / "docs" / "speed.csv"
IMPORTS = "import numpy, scipy.linalg, numba, xarray, h5netcdf"
SIXTEEN = ("discretization.frame=mean-axis", "discretization.modes=16")

#: what the ratio is of, the ratio, the aim
Row = tuple[str, float, str]


def imports() -> float:
    """Return the processor seconds of the libraries' imports."""
    return process_cost(["-c", IMPORTS])


def start_up(turns: int) -> Iterator[Row]:
    """Yield runs from the command line over the imports of their libraries."""
    with tempfile.TemporaryDirectory() as folder:

        def run(name: str, **environment: str) -> float:
            return process_cost(["-m", "oblique_impact", "run", name, "--out", f"{folder}/{name}"], **environment)

        for name in builtin_names():
            run(name)  # compiles what is missing
            ratio = median_ratio(turns, lambda name=name: run(name), imports)
            yield f"warm run of `{name}` over imports", ratio, "2.5"
        # one turn is enough for a ratio that large
        first = median_ratio(1, lambda: run("paper", NUMBA_CACHE_DIR=f"{folder}/cache"), imports)
        yield "first run of `paper` over imports", first, "10"


def many_modes(turns: int) -> Iterator[Row]:
    """Yield the marching of sixteen mean-axis modes over the imports."""
    march = partial(march_cost, Scenario.builtin("paper", SIXTEEN))
    march()
    yield "marching 1 s with 16 mean-axis modes over imports", median_ratio(turns, march, imports), "1.1"


# Steps of the full nodal model ----------------------------------------------------------------------------------

NODAL = (
    *("contact.normal=spring", "contact.friction=frictionless", "discretization.method=fem"),
    *("discretization.modes=0", "solver.output_interval=0.05"),
)
#: at rest on a soft stop, and a flight far above the slope; in the steps of the built-in cases (s)
CONTACT = (
    *("slope.origin=[0.0, 0.0]", "slope.angle=0.0", "initial.angle=0.0"),
    *("contact.stiffness=1e4", "solver.rho_infinity=0.0"),
)
KINDS = {"contact": (CONTACT, 1e-6), "flight": (("slope.origin=[0.0, -5.0]",), 1e-4)}
STEPS = {128: 2000, 1024: 250}  # of a run, by the number of elements


def step_cost(elements: int, kind: str) -> float:
    """Return the processor seconds of one step."""
    changes, step = KINDS[kind]
    mesh = (f"discretization.elements={elements}", f"end_time={STEPS[elements] * step}")
    return march_cost(Scenario.builtin("paper", [*NODAL, *changes, *mesh])) / STEPS[elements]


def nodal_steps(turns: int) -> Iterator[Row]:
    """Yield the costs of steps of the nodal model over each other."""
    for kind in KINDS:
        step_cost(128, kind)
    for elements in STEPS:
        flight, contact = (partial(step_cost, elements, kind) for kind in ("flight", "contact"))
        ratio = median_ratio(turns, flight, contact)
        yield f"nodal step, flight over contact, {elements:,} elements", ratio, "1.5"
    for kind in KINDS:
        ratio = median_ratio(turns, partial(step_cost, 1024, kind), partial(step_cost, 128, kind))
        yield f"nodal step, 1,024 over 128 elements, {kind}", ratio, "9"


# Time-stepping --------------------------------------------------------------------------------------------------


def on_pegs(pegs: int, elements: int) -> Scenario:
    """Return a beam at rest on pegs from a fifth of its length on, all of which it presses."""
    places = [0.2 + 0.75 * i / max(pegs - 1, 1) for i in range(pegs)] if pegs > 1 else [0.7]
    step = 5e-6  # s
    return Scenario.builtin("slap").adapted(
        beam__kelvin_voigt=1e-3,
        discretization__elements=elements,
        end_time=2_000 * step,
        initial__angle=0.0,
        obstacles=[{"kind": "point", "origin": [place, -1e-3], "radius": 1e-3} for place in places],
        solver__free_step=step,
        solver__contact_step=step,
    )


def time_stepping(turns: int) -> Iterator[Row]:
    """Yield the marching of `slap` over the imports, and costs of steps with many contacts over each other."""
    slap, one, ten, coarse, fine = (
        partial(march_cost, scenario)
        for scenario in (
            Scenario.builtin("slap"),
            *(on_pegs(pegs, elements) for pegs, elements in ((1, 64), (10, 64), (10, 128), (10, 1024))),
        )
    )
    for march in (slap, one):
        march()  # compiles what is missing
    yield "marching `slap` over imports", median_ratio(turns, slap, imports), "2"
    yield "time-stepping, ten closed contacts over one, 64 elements", median_ratio(turns, ten, one), "3"
    yield "time-stepping, 1,024 over 128 elements, ten contacts", median_ratio(turns, fine, coarse), "10"


# Files ----------------------------------------------------------------------------------------------------------

#: print the processor seconds of a second call, which imports and compiles nothing
SAVE = """
import tempfile, time
from oblique_impact import Scenario, simulate
with tempfile.TemporaryDirectory() as folder:
    for _ in range(2):
        history = simulate(Scenario.builtin("paper"))
        started = time.process_time()
        history.save(folder)
        cost = time.process_time() - started
print(cost)
"""
LOAD = """
import time
from oblique_impact import History
for _ in range(2):
    started = time.process_time()
    History.load({folder!r})
    cost = time.process_time() - started
print(cost)
"""


def files(turns: int) -> Iterator[Row]:
    """Yield bytes and numbers of files of `paper`, and costs of its history, over those of the older program."""
    with tempfile.TemporaryDirectory() as folder:
        old = {**old_program(), "NUMBA_CACHE_DIR": f"{folder}/cache"}
        programs = {"now": {}, "then": old}
        sizes = dict[tuple[str, str], tuple[int, int]]()
        for name, environment in programs.items():
            here = Path(folder) / name
            process_cost(["-m", "oblique_impact", "run", "paper", "--out", f"{here}/run"], **environment)
            sizes[name, "history.nc"] = (here / "run" / "history.nc").stat().st_size, 1
            for format in ("pvd", "xdmf"):
                words = ["export", f"{here}/run", "--format", format, "--out", f"{here}/{format}/beam"]
                (here / format).mkdir()
                process_cost(["-m", "oblique_impact", *words], **environment)
                sizes[name, format] = size_on_disk(here / format)
        for what, aim in (("history.nc", "0.5"), ("pvd", "0.25"), ("xdmf", "0.333")):
            ratio = sizes["now", what][0] / sizes["then", what][0]
            yield f"bytes of `{what}` of `paper` over {OLD}", ratio, aim
        yield f"files of `pvd` of `paper` over {OLD}", sizes["now", "pvd"][1] / sizes["then", "pvd"][1], "0.5"
        for what, script, aim in (("saving", SAVE, "2"), ("loading", LOAD, "1.2")):
            now, then = (
                partial(printed, script.replace("{folder!r}", repr(f"{folder}/{name}/run")), **environment)
                for name, environment in programs.items()
            )
            yield f"{what} a history of `paper` over {OLD}", median_ratio(turns, now, then), aim


def films(turns: int) -> Iterator[Row]:
    """Yield a film over a bare loop of PyVista."""
    yield "film of `paper` over a bare PyVista loop", median_ratio(min(turns, 3), *film_costs()), "1.3"


# Others ---------------------------------------------------------------------------------------------------------

#: prints the processor seconds of runs of a study
RUNS = """
import time, warnings
warnings.simplefilter("ignore")
from oblique_impact import Scenario, simulate
scenario = Scenario.builtin("paper", ["solver.output_interval=0.01"])
simulate(scenario)
started = time.process_time()
for _ in range(60):
    simulate(scenario)
print(time.process_time() - started)
"""

SWEEP = """
quantities = ["impulse", "energy_final"]
changes.solver.output_interval = 0.01
[[axes]]
keys = ["contact.mu_static", "contact.mu_kinetic"]
range = [0.0, 0.6]
count = {frictions}
[[axes]]
key = "slope.angle"
range = [0.2, 0.4]
count = 32
"""


def runs(turns: int) -> Iterator[Row]:
    """Yield runs of `paper` with few samples, as studies have them, over those of the older program."""
    now, then = partial(printed, RUNS), partial(printed, RUNS, **old_program())
    then()  # compiles what is missing
    yield f"run of `paper`, samples every 10 ms, over {OLD}", median_ratio(turns, now, then), "0.5"


def sweeps(turns: int) -> Iterator[Row]:
    """Yield the wall time of a sweep, times its processes, over the time that its runs take by themselves.

    A first, short one starts the processes and loads the kernels.
    """
    workers = 2
    with tempfile.TemporaryDirectory() as folder:
        for frictions in (4, 32):
            plan = make_plan(SWEEP.format(frictions=frictions))
            result = sweep(plan, f"{folder}/{frictions}", workers=workers)
    assert set(result.verdicts) == {"completed"}, result.verdicts
    yield "sweep of 1,000 runs over its runs", result.seconds * workers / result.frame["wall_time"].sum(), "1.15"


def peers(turns: int) -> Iterator[Row]:
    """Yield how much longer MuJoCo takes to the same impulses, where it is installed.

    It keeps no samples; ours are 10 ms apart, and 0.1 ms as they are by default.
    """
    if find_spec("mujoco") is None:
        return
    for c in CHEAPEST:
        problem, given, limit = c.problem, Scenario.load(SCENARIOS[c.problem]), LIMITS[c.problem][0]
        places = {"contact__grid": c.places} if given.sides else {}
        changed = given.replace(discretization__elements=c.elements, solver__contact_step=c.step, **places)
        impulse = sum(contact.normal_impulse for contact in simulate(changed).contacts)
        assert abs(impulse / limit - 1.0) < c.error, (problem, impulse)
        chain = partial(mujoco_chain.march, given, c.links, c.link_step)
        assert abs(chain().impulse / limit - 1.0) < c.error, problem
        for interval, words in ((1e-2, ""), (1e-4, ", samples every 0.1 ms")):
            march = partial(march_cost, changed.replace(solver__output_interval=interval))
            ratio = median_ratio(turns, lambda: chain().processor, march)  # noqa: B023  within this turn
            yield (
                f"MuJoCo over time-stepping, {problem} to {100.0 * c.error:g} %, {c.elements} elements{words}",
                ratio,
                f"at least {c.aim:g}",
            )


def others(turns: int) -> Iterator[Row]:
    """Yield how much longer other solvers take to errors of 1e-3, 1e-4 and 1e-5."""
    points = work_precision.measure(turns)
    work_precision.keep(points)
    for largest in (1e-3, 1e-4, 1e-5):
        for solver, ratio in work_precision.ratios(points, largest).items():
            yield f"{solver} over oblique-impact, error {largest:g}", ratio, "at least 10"


def main(turns: int = 5) -> None:
    """Measure, keep and print."""
    rows = []
    for group in (start_up, many_modes, nodal_steps, time_stepping, peers, files, films, runs, sweeps, others):
        for what, ratio, aim in group(turns):
            rows.append((what, f"{ratio:.3g}", aim))
            print(f"{what}: {ratio:.3g}", flush=True)
    write_csv(STORE, ("cost", "ratio", "aim"), rows)
    print_table("Ratios, medians", ("cost", "ratio", "aim"), rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
