"""Warnings about results that do not converge: what they advise is enough, no damping is fitted to a mesh."""

import math
import re

import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.validity.limits import friction_warnings, impact_warnings, unconverged_results
from oblique_impact.beam_problem import beam_of
from oblique_impact.command_line.run import summary_lines

DAMPED = "beam.kelvin_voigt=1e-5"
SPRING = "contact.normal=spring"
MEAN_AXIS = "discretization.frame=mean-axis"
ALL = ("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force")
STEPS = (*("contact.where=anywhere", "contact.grid=1", "solver.scheme=time-stepping"), MEAN_AXIS)
NODAL = ("discretization.method=fem", "discretization.modes=0")
#: a steel strip of 0.2 m x 10 mm x 1 mm on a spring that is stiffer than what two modes leave out of its tip
STRIP = (
    *("beam.length=0.2", "beam.area=1e-5", "beam.second_moment=8.333333333e-13", "beam.material=steel"),
    *("slope.origin=[0.06, 0]", SPRING, "contact.stiffness=1e6", "contact.friction=frictionless", "end_time=0.18"),
)


def said(*changes: str, most=3) -> str:
    """The one line about a run of the paper's case, "" for none."""
    scenario = Scenario.builtin("paper", changes)
    lines = friction_warnings(scenario, most) + impact_warnings(scenario, most, beam_of(scenario))
    assert len(lines) <= 1
    return "".join(lines)


def advice(line: str) -> tuple[str, ...]:
    """The number of modes or elements and the frame that a line recommends, as changes of a scenario."""
    count, kind = re.search(r"about (\d+) (modes|elements)", line).groups()
    frame = re.findall(r'discretization\.frame = "([a-z-]+)"', line)
    return (f"discretization.{kind}={count}", *(f"discretization.frame={name}" for name in frame))


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ((), ALL),
        ((DAMPED,), ("peak_force",)),
        ((SPRING, "contact.stiffness=1e6"), ()),
        # a thousand times 105 EI/(2 L^3), the stiffness of the hinged beam at its tip: 2.84e7 N/m
        ((SPRING, "contact.stiffness=2.8e7"), ()),
        ((SPRING, "contact.stiffness=2.9e7"), ALL),
        ((SPRING, "contact.stiffness=1e9"), ALL),
        ((SPRING, "contact.stiffness=1e9", DAMPED), ()),
        (("contact.enabled=false",), ()),
        # friction along a beam that cannot stretch, in time-stepping
        ((*STEPS, DAMPED), ("tangential_impulse", "peak_force")),
        ((*STEPS, DAMPED, "contact.axial_flexibility=true"), ("peak_force",)),
        ((*STEPS, DAMPED, "contact.friction=frictionless"), ("peak_force",)),
        (STEPS, ALL),
    ],
)
def test_what_has_no_limit(changes, names):
    assert unconverged_results(Scenario.builtin("paper", changes)) == names


@pytest.mark.parametrize(
    "changes",
    [
        (),
        (MEAN_AXIS, "discretization.modes=8"),
        (*NODAL, "discretization.elements=12"),
        (SPRING, "contact.stiffness=1e9"),
    ],
    ids=["tangent", "mean-axis", "nodal", "stiff spring"],
)
def test_the_damping_that_is_proposed_is_light_whatever_the_mesh(changes):
    """A fifth of a per cent of critical, and the modes or elements that are named with it resolve it."""
    line = said(*changes)
    assert "no limit" in line
    proposed = float(re.search(r"beam\.kelvin_voigt \(([0-9.e-]+) s", line).group(1))
    assert 0.5 * proposed * lowest_elastic_frequency(Scenario()) == pytest.approx(0.002, rel=0.06)
    assert said(*changes, *advice(line), f"beam.kelvin_voigt={proposed}") == ""
    assert said(*changes, most=0) == ""  # it did not come to a contact


@pytest.mark.parametrize(
    "changes",
    [
        (),
        (MEAN_AXIS, "discretization.modes=8"),
        ("discretization.method=fem", "discretization.modes=4", MEAN_AXIS),
        (*NODAL, "discretization.elements=16"),
        ("root.kind=driven", "root.profile=constant-speed", "root.spin_rate=-2"),
    ],
    ids=["tangent", "mean-axis", "reduced elements", "nodal", "driven"],
)
def test_damping_that_is_not_resolved_asks_for_modes_or_elements(changes):
    """And for no other damping: eta omega_N >= 0.5 for N modes, h <= pi sqrt(eta c) for elements."""
    line = said(*changes, DAMPED)
    assert line.startswith("beam.kelvin_voigt: 1e-05 s is not resolved")
    assert re.findall(r"([0-9.e-]+) s\b", line) == ["1e-05"]
    key, count = advice(line)[0].split("=")
    assert said(*changes, *advice(line), DAMPED) == ""
    assert said(*changes, *advice(line), f"{key}={int(0.85 * int(count))}", DAMPED) != ""


def test_a_soft_stop_that_is_met_very_often_is_named_too():
    soft = (SPRING, "contact.stiffness=1e7")
    assert said(*soft, most=20) == ""
    assert "met 21 times" in said(*soft, most=21)


def test_places_that_touch_a_bed_at_once_meet_it_once():
    """A fall onto a bed closes forty places, and the beam meets it once or twice: nothing is magnified."""
    bed = {"kind": "side", "origin": [0.0, -0.02], "bedding": 1e5}
    contact = {"where": "anywhere", "normal": "spring", "friction": "frictionless", "grid": 64}
    fall = {"slope": {"enabled": False}, "contact": contact, "obstacles": [bed], "end_time": 0.45}
    history = simulate(Scenario.from_dict(fall | {"discretization": {"frame": "mean-axis", "modes": 6}}))
    assert history.macro_collisions[0]["contacts"] > 20
    assert not any("not determined" in words for words in history.summary["warnings"])
    assert history.summary["without_limit"] == []


def converged_peak(case: tuple[str, ...], line: str) -> float:
    """The largest force (N) with half as many modes more than a line recommends, which already give it."""
    enough = advice(line)
    many = (*enough, f"discretization.modes={math.ceil(1.5 * int(enough[0].split('=')[1]))}")
    histories = [simulate(Scenario.builtin("paper", [*case, *changes])) for changes in (enough, many)]
    assert not any("leave out" in words for history in histories for words in history.summary["warnings"])
    recommended, more = (history.macro_collisions[0]["peak_force"] for history in histories)
    assert recommended == pytest.approx(more, rel=0.02)
    return more


def test_a_spring_on_too_few_modes_says_how_many_give_the_force():
    """With two modes it is less than a third."""
    few = simulate(Scenario.builtin("paper", STRIP))
    (line,) = (words for words in few.summary["warnings"] if words.startswith("contact.stiffness"))
    assert few.macro_collisions[0]["peak_force"] < converged_peak(STRIP, line) / 3.0


def test_a_spring_of_an_obstacle_is_judged_at_its_own_place_and_stiffness():
    """A peg of 1e6 N/m at 0.08 m of the strip; `contact.stiffness` is that of pegs without a stiffness."""
    peg = "obstacles=[{kind='point', origin=[0.08, 0.0], stiffness=1e6}]"
    onto = [key for key in STRIP if not key.startswith("slope.")]
    onto += [
        MEAN_AXIS,
        "slope.enabled=false",
        "contact.where=anywhere",
        peg,
        "end_time=0.1",
        "initial.angle=20 deg",
    ]
    few = simulate(Scenario.builtin("paper", [*onto, "discretization.modes=8"]))
    (line,) = (words for words in few.summary["warnings"] if "leave out" in words)
    assert line.startswith("obstacles.1.stiffness: ")
    assert "at x = 0.08 m" in line
    assert few.macro_collisions[0]["peak_force"] > 1.05 * converged_peak(onto, line)
    # a stiff peg is a rigid one, whichever key makes it stiff
    soft = "obstacles=[{kind='point', origin=[0.5, 0.0], stiffness=1e6}]"
    anywhere = (SPRING, "slope.enabled=false", "contact.where=anywhere")
    assert unconverged_results(Scenario.builtin("paper", [*anywhere, soft])) == ()
    for stiff in ([soft.replace("1e6", "1e9")], [soft.replace(", stiffness=1e6", ""), "contact.stiffness=1e9"]):
        assert unconverged_results(Scenario.builtin("paper", [*anywhere, *stiff])) == ALL


@pytest.mark.parametrize(("normal", "peak"), [("rigid", False), ("spring", True)])
def test_a_peak_that_has_no_limit_is_not_printed(normal, peak, tmp_path, capsys):
    changes = (f"contact.normal={normal}", "end_time=0.34", MEAN_AXIS, "discretization.modes=8")
    history = simulate(Scenario.builtin("paper", changes))
    print("\n".join(summary_lines(history, tmp_path, False)))
    shown = capsys.readouterr().out
    assert (", peak " in shown) is peak
    assert ("warning: contact.normal: a rigid stop" in shown) is not peak
    assert history.summary["macro_collisions"][0]["peak_force"] > 0.0
