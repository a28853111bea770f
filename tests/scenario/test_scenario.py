"""Scenarios: the paper's defaults, files and changes, keys that follow others, one line for bad input."""

from __future__ import annotations

import inspect
import math
import pickle
import re
import tomllib

import pytest

from oblique_impact import InputError, Scenario, natural_frequencies, simulate
from oblique_impact.renders.style import Style
from oblique_impact.scenario import sections
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.sections import BeamSection, ContactSection, DiscretizationSection
from tests.refusals import refused_in_one_line

#: the paper's data (its Sec. 7), and what the design of the program takes where the paper is silent
PAPER = {
    "end_time": 1.0,
    "gravity": 9.8,
    "beam": {
        "length": 1.0,
        "area": 3.14e-4,
        "second_moment": 7.85e-9,
        "density": 2766.7,
        "youngs_modulus": 68.952e9,
        "kelvin_voigt": 0.0,
    },
    "root": {"kind": "pin", "hub_radius": 0.0, "profile": "hold"},
    "initial": {"angle": math.pi / 4, "angular_velocity": 0.0},
    "slope": {"origin": (0.3, 0.0), "angle": math.pi / 10},
    "contact": {
        "point": 1.0,
        "normal": "rigid",
        "restitution": 0.0,
        "shortening": True,
        "friction": "hybrid",
        "mu_static": 0.3,
        "mu_kinetic": 0.3,
    },
    "discretization": {"method": "modal", "frame": "tangent", "kinetics": "first-order", "modes": 2},
    "solver": {"scheme": "event", "tolerance": 1e-10, "baumgarte": (10.0, 1000.0), "output_interval": 1e-4},
}
NODAL = ("discretization.method=fem", "discretization.modes=0")


def test_defaults_are_the_papers_case():
    resolved = Scenario().model_dump()
    for key, expected in PAPER.items():
        if isinstance(expected, dict):
            assert {name: resolved[key][name] for name in expected} == expected
        else:
            assert resolved[key] == expected
    assert Scenario.builtin("paper") == Scenario()


# --- files and changes


@pytest.mark.parametrize("name", builtin_names())
def test_a_saved_file_is_the_same_scenario_and_takes_changes_as_the_built_in_case(name):
    scenario = Scenario.builtin(name)
    text = scenario.to_toml()
    again = Scenario.from_toml(text)
    assert again == scenario
    assert again.to_toml() == text
    for changes in (["beam.tip_mass=0"], ["end_time=0.5", "gravity=0"], ["solver.output_interval=1e-3"]):
        assert Scenario.from_toml(text, changes) == Scenario.builtin(name, changes)


def test_a_file_keeps_every_digit_and_any_title():
    scenario = Scenario().replace(
        title='"é" \\ {x}\t#',
        initial__angle=1.0 + 2.0**-52,
        gravity=9.80665,
        slope__origin=[0.1 + 0.2, -1e-300],
        discretization__method="fem",
        discretization__nodes=[k / 30 for k in range(30)] + [1.0],
    )
    assert Scenario.from_toml(scenario.to_toml()) == scenario


@pytest.mark.parametrize("character", ["\x00", "\x07", "\x1b", "\n", "\x7f", "\x85", "\uffff"])
def test_control_characters_in_a_title_are_refused(character):
    """XML has none: a picture as SVG and an export as XDMF could not be read."""
    with refused_in_one_line("title = ", "should be a text without control characters"):
        Scenario.from_dict({"title": f"a{character}b"})
    with refused_in_one_line("--title a", "should be a text without control characters"):
        Style(title=f"a{character}b")


def test_load_reads_names_and_files(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text("[beam]\nlength = 2.0\n", encoding="utf-8")
    assert Scenario.load(str(file), ["beam.density=1000"]).beam.density == 1000.0
    assert Scenario.load("bouncing") == Scenario.builtin("bouncing")


@pytest.mark.parametrize(
    ("change", "section", "key", "value"),
    [
        (" beam . length = 2.5 ", "beam", "length", 2.5),
        ("contact.friction=frictionless", "contact", "friction", "frictionless"),
        ("contact.enabled=false", "contact", "enabled", False),
        ("slope.origin=[0.25, -0.5]", "slope", "origin", (0.25, -0.5)),
    ],
)
def test_changes_on_the_command_line(change, section, key, value):
    assert getattr(getattr(Scenario.from_toml("", [change]), section), key) == value


# --- keys that follow others


def test_the_contact_point_stays_at_the_tip_unless_it_was_given():
    saved = Scenario().to_toml()
    assert Scenario.from_toml("", ["beam.length=2"]).contact.point == 2.0
    assert Scenario.from_toml(saved, ["beam.length=2"]).contact.point == 2.0
    assert Scenario(contact=ContactSection(mu_static=0.5), beam={"length": 2.0}).contact.point == 2.0
    given = Scenario.from_toml("[contact]\npoint = 1.0")
    changed = Scenario.from_toml(saved.replace("point = 1.0\n", "point = 0.5\n", 1))
    for scenario, point in ((given, 1.0), (Scenario.from_toml(given.to_toml()), 1.0), (changed, 0.5)):
        assert scenario.replace(beam__length=2.0).contact.point == point
    follows = pickle.loads(pickle.dumps(Scenario()))
    assert follows.replace(beam__length=2.0).replace(end_time=0.1).contact.point == 2.0


def test_the_resolved_file_is_complete_and_lists_what_was_not_given():
    found = tomllib.loads(Scenario.from_toml("[contact]\npoint = 0.5").to_toml())
    assert found["contact"]["point"] == 0.5
    assert (found["solver"]["scheme"], found["discretization"]["frame"]) == ("event", "tangent")
    assert found["derived"] == {"discretization.frame": "tangent", "contact.grid": 1, "solver.scheme": "event"}


def test_the_full_nodal_model_takes_the_scheme_and_frame_that_march_it():
    for scenario in (
        Scenario.builtin("paper", [*NODAL]),
        Scenario(discretization=DiscretizationSection(method="fem", modes=0)),
        Scenario().replace(discretization__method="fem", discretization__modes=0),
        Scenario.from_toml(Scenario().to_toml(), [*NODAL]),
    ):
        assert (scenario.solver.scheme, scenario.discretization.frame) == ("time-stepping", "mean-axis")
        for without in ({"normal": "spring"}, {"enabled": False}, {"point_inertia": "none"}):
            changed = scenario.replace(**{f"contact__{name}": value for name, value in without.items()})
            assert changed.solver.scheme == "generalized-alpha"
        back = scenario.replace(discretization__modes=4)
        assert (back.solver.scheme, back.discretization.frame) == ("event", "tangent")
    kept = Scenario.builtin("elastic-stop").replace(discretization__modes=4)  # there they are given
    assert (kept.solver.scheme, kept.discretization.frame) == ("generalized-alpha", "mean-axis")


# --- bad input

# text of a scenario file -> what the one line must name
BAD = {
    "unknown key": ("gravitation = 9.8", ["gravitation", "9.8", "gravity", "end_time"]),
    "unknown section": ("[beams]\nlength = 1.0", ["beams", "did you mean beam?", "slope"]),
    "unknown key in a section": ("[beam]\nlenght = 2.0", ["beam.lenght = 2.0", "did you mean length?", "area"]),
    "nothing similar": ("[beam]\nqqq = 2.0", ["beam.qqq = 2.0: unknown key; allowed here: length, area"]),
    "key of another section": ("[slope]\nmu_static = 2.0", ["slope.mu_static", "did you mean contact.mu_static?"]),
    "key without its section": ("mu_static = 2.0", ["mu_static = 2.0", "did you mean contact.mu_static?"]),
    "unknown word": ('[contact]\nnormal = "sprng"', ['"rigid" or "spring"', 'did you mean "spring"?']),
    "string for a float": ('[beam]\nlength = "long"', ["beam.length", '"long"', "number"]),
    "three numbers for a pair": ("[slope]\norigin = [0.0, 1.0, 2.0]", ["slope.origin", "at most 2 items"]),
    "NaN": ("gravity = nan", ["gravity", "nan", "finite"]),
    "NaN in a pair": ("[slope]\norigin = [nan, 0.0]", ["slope.origin.0", "nan", "finite"]),
    "not TOML": ("\nend_time = = 1", ["scenario file, line 2", "not valid TOML"]),
    "value with a line break": ('[beam]\nlength = "a\\nb"', ["beam.length", "number"]),
    "senseless derived values": ('[derived]\n"beam.length" = 1.0', ["derived", "contact.point"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line_with_key_value_and_what_is_allowed(name):
    text, parts = BAD[name]
    with refused_in_one_line(*parts):
        Scenario.from_toml(text)


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ("beam.length", ["beam.length", "section.key=value"]),
        ("beam.length.unit=m", ["beam.length.unit=m", "section.key=value"]),
        ("end_time.x=2", ["end_time.x=2", "end_time", "not a section"]),
        ("beam.length=", ["beam.length", '""', "number"]),
    ],
)
def test_bad_changes_are_one_line(change, parts):
    with refused_in_one_line(*parts):
        Scenario.from_toml("end_time = 1.0", [change])


def test_a_fault_of_a_file_names_the_file_and_one_of_a_change_does_not(tmp_path):
    file = tmp_path / "beam.toml"
    file.write_text("[beam]\nlength = 2.0\n")
    with refused_in_one_line(start="beam.length = -1: "):
        Scenario.load(str(file), ["beam.length=-1"])
    file.write_text("[beam]\nlength = -2.0\n")
    with refused_in_one_line(start=f"{file}: beam.length = -2.0: "):
        Scenario.load(str(file), ["end_time=0.1"])


def test_missing_and_unreadable_files(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"# caf\xe9\n")
    for source, allowed in [
        (str(tmp_path / "missing.toml"), "built-in"),
        (str(tmp_path), "built-in"),
        (str(latin), "cannot be read"),
        ("stiking", "did you mean sticking"),
    ]:
        with refused_in_one_line(source, allowed):
            Scenario.load(source)
    with pytest.raises(InputError, match=r"nowhere.*paper.*sticking"):
        Scenario.builtin("nowhere")


@pytest.mark.parametrize(
    ("make", "start"),
    [
        (lambda: Scenario(beam={"lenght": 2}), "beam.lenght = 2: unknown key; did you mean length?"),
        (lambda: Scenario(beam={"section": {"width": -1.0}}), "beam.section.width = -1.0: should be"),
        (lambda: Scenario(contact={"mu_static": 0.1}), "contact.mu_static = 0.1: should be at least"),
        (lambda: Scenario.from_dict(3), "Scenario = 3: should be"),
        (lambda: Scenario().replace(bema__length=2), "bema = {length = 2}: unknown key; did you mean beam?"),
        (lambda: BeamSection(length="12 kg"), 'length = "12 kg": should be in m, not in kg'),
        (lambda: setattr(Scenario().beam, "length", 2.0), "length = 2.0: scenarios are frozen"),
        (lambda: simulate("paper"), 'simulate: scenario = "paper": should be a Scenario'),
        (lambda: natural_frequencies("paper", [0.0]), 'natural_frequencies: scenario = "paper": should be'),
    ],
    ids=range(9),
)
def test_a_bad_argument_in_python_is_one_line_too(make, start):
    with refused_in_one_line(start=start):
        make()


@pytest.mark.parametrize("name", builtin_names())
def test_its_repr_is_the_call_that_makes_it(name):
    scenario = Scenario.builtin(name)
    assert eval(repr(scenario), vars(sections) | {"Scenario": Scenario}) == scenario
    assert "baumgarte" not in repr(scenario.replace(gravity=9.81))
    assert "gravity=9.81" in str(scenario.replace(gravity=9.81))


def test_help_lists_every_key_with_its_unit():
    text = inspect.getdoc(Scenario)
    assert all(f"{key.rpartition('.')[2]} = " in text for key in key_schemas())
    assert re.search(r"^ *density = 2766\.7 +# kg/m³, ", text, re.MULTILINE)


def test_the_earlier_name_of_the_stick_projection_is_read():
    text = Scenario().replace(solver__scheme="fixed-step").to_toml()
    assert 'stick = "projection"' in text
    assert Scenario.from_toml(text.replace('"projection"', '"arrest"')) == Scenario.from_toml(text)
    with refused_in_one_line("solver.stick", '"arrested"', "projection"):
        Scenario.from_toml(text.replace('"projection"', '"arrested"'))


def test_the_earlier_name_of_the_scheme_of_absolute_coordinates_is_read(caplog):
    """The resolved file has the new one, and a line says so."""
    words = "discretization.method=absolute", "contact.normal=spring", "solver.scheme=energy-consistent"
    assert 'scheme = "time-stepping"' in Scenario.builtin("paper", words).to_toml()
    assert '"energy-consistent" is now called "time-stepping"' in caplog.text
