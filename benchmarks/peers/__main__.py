"""MuJoCo and Exudyn on the tip on a slope, the beam that slaps onto a table, and two circles.

    PYTHONPATH=benchmarks python -m peers      a minute; pip install "oblique-impact[bench]"

All three are rigid and without friction, and damped, so that there is a limit: that of the event scheme and of
time-stepping as elements, modes and steps are refined.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from measuring import march_cost, print_table

from oblique_impact import Scenario, simulate
from oblique_impact.errors import InputError
from peers import exudyn_cables, mujoco_chain
from peers.problems import LIMITS, SCENARIOS, Found


def _ours(scenario: Scenario, elements: int, step: float) -> Found:
    places = {"contact__grid": elements} if scenario.sides else {}
    changed = scenario.replace(discretization__elements=elements, solver__contact_step=step, **places)
    history = simulate(changed)  # compiles what is missing
    impulse = sum(collision["normal_impulse"] for collision in history.summary["macro_collisions"])
    return Found(impulse, max(0.0, -float(history["gap"].min())), march_cost(changed))


def runs(problem: str, scenario: Scenario) -> Iterator[tuple[str, str, Callable[[], Found]]]:
    """Yield program, settings and run."""
    for elements, step in ((32, 1e-5), (64, 5e-6)):
        yield "oblique-impact", f"{elements} elements, {step:g} s", partial(_ours, scenario, elements, step)
    for links, step in ((20, 2e-5), (40, 1e-5), (80, 5e-6)):
        yield "MuJoCo", f"{links} links, {step:g} s", partial(mujoco_chain.march, scenario, links, step)
    for elements, step, bedding in ((32, 1e-5, 1e8), (32, 5e-6, 1e9), (32, 1e-6, 1e10)):
        settings = f"{elements} elements, {step:g} s, {bedding:g} N/m^2"
        yield "Exudyn", settings, partial(exudyn_cables.march, problem, scenario, elements, step, bedding)


def rows(problem: str) -> Iterator[list[str]]:
    """Yield what each program finds."""
    scenario, (limit, _) = Scenario.load(SCENARIOS[problem]), LIMITS[problem]
    for program, settings, run in runs(problem, scenario):
        try:
            found = run()
        except ImportError:
            yield [program, settings, "not installed", "", "", ""]
            continue
        except InputError:
            raise
        except Exception as error:  # what a foreign solver raises where it gives up
            yield [program, settings, f"fails: {str(error).splitlines()[0][:40]}", "", "", ""]
            continue
        error = f"{100.0 * (found.impulse / limit - 1.0):+.2f} %"
        impulse, depth = f"{found.impulse:.4f}", f"{1e6 * found.depth:.1f}"
        yield [program, settings, impulse, error, depth, f"{found.processor:.2f}"]


def main() -> None:
    """Measure and print."""
    for problem, (limit, uncertainty) in LIMITS.items():
        title = f"{problem}: {limit} +- {uncertainty} N s"
        headings = ("program", "settings", "impulse, N s", "error", "depth, 1e-6 m", "CPU s")
        print_table(title, headings, rows(problem))


if __name__ == "__main__":
    main()
