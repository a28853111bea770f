"""Scenario files: the paper's defaults, the round trip, and one line for every kind of bad input."""

import math

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.scenario.sections import MAX_ELEMENTS, MAX_MODES

# docs: the design page's scenario file; the paper's data, its Sec. 7
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
        "mass_proportional": 0.0,
        "modal_damping_ratio": 0.0,
    },
    "root": {"kind": "pin", "hub_radius": 0.0, "profile": "hold", "spin_rate": 0.0, "spin_up_time": 0.0},
    "initial": {"angle": math.pi / 4, "angular_velocity": 0.0},
    "slope": {"origin": (0.3, 0.0), "angle": math.pi / 10},
    "contact": {
        "enabled": True,
        "point": 1.0,
        "normal": "rigid",
        "stiffness": 1e6,
        "damping": 0.0,
        "restitution": 0.0,
        "shortening": True,
        "friction": "hybrid",
        "mu_static": 0.3,
        "mu_kinetic": 0.3,
        "regularization": (1e-3, 1e-2),
    },
    "discretization": {
        "method": "modal",
        "frame": "tangent",
        "kinetics": "first-order",
        "modes": 2,
        "elements": 32,
    },
    "solver": {
        "scheme": "event",
        "tolerance": 1e-10,
        "free_step": 1e-4,
        "contact_step": 1e-6,
        "rho_infinity": 0.8,
        "baumgarte": (10.0, 1000.0),
        "output_interval": 1e-4,
    },
}


def one_line(error):
    message = str(error.value)
    assert message.strip()
    assert len(message.splitlines()) == 1, message
    return message


def test_defaults_are_the_papers_case():
    resolved = Scenario().model_dump()
    for key, expected in PAPER.items():
        if isinstance(expected, dict):
            assert {name: resolved[key][name] for name in expected} == expected
        else:
            assert resolved[key] == expected
    assert Scenario.builtin("paper") == Scenario()


def test_contact_point_defaults_to_the_length_of_any_beam():
    assert Scenario.from_toml("[beam]\nlength = 2.5").contact.point == 2.5
    assert Scenario().replace(beam__length=3.0).contact.point == 3.0
    assert Scenario().replace(beam__length=3.0, contact__point=2.0).contact.point == 2.0


@pytest.mark.parametrize("name", builtin_names())
def test_toml_round_trip(name):
    scenario = Scenario.builtin(name)
    text = scenario.to_toml()
    again = Scenario.from_toml(text)
    assert again == scenario
    assert again.to_toml() == text


def test_round_trip_keeps_every_digit():
    scenario = Scenario().replace(
        initial__angle=1.0 + 2.0**-52, gravity=9.80665, slope__origin=[0.1 + 0.2, -1e-300]
    )
    assert Scenario.from_toml(scenario.to_toml()) == scenario


def test_load_reads_names_and_files(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text("[beam]\nlength = 2.0\n", encoding="utf-8")
    assert Scenario.load(str(file), ["beam.density=1000"]).beam.density == 1000.0
    assert Scenario.load("bouncing") == Scenario.builtin("bouncing")


# text of the scenario file -> what the one line must name
BAD = {
    "unknown key": ("gravitation = 9.8", ["gravitation", "9.8", "gravity", "end_time"]),
    "unknown section": ("[beams]\nlength = 1.0", ["beams", "beam", "slope"]),
    "unknown key in a section": ("[beam]\nlenght = 2.0", ["beam.lenght", "2.0", "length", "area"]),
    "string for a float": ('[beam]\nlength = "long"', ["beam.length", "'long'", "number"]),
    "number for a string": ("[discretization]\nframe = 3", ["discretization.frame", "3", "tangent", "mean-axis"]),
    "number for a section": ("beam = 3.0", ["beam", "3.0", "dictionary"]),
    "list for a float": ("end_time = [1.0]", ["end_time", "[1.0]", "number"]),
    "float for an integer": ("[discretization]\nmodes = 2.0", ["discretization.modes", "2.0", "integer"]),
    "bool for a float": ("[beam]\nlength = true", ["beam.length", "True", "number"]),
    "bool for an integer": ("[discretization]\nmodes = true", ["discretization.modes", "True", "integer"]),
    "integer for a bool": ("[contact]\nenabled = 1", ["contact.enabled", "1", "boolean"]),
    "bool in a pair": ("[slope]\norigin = [true, 0.0]", ["slope.origin.0", "True", "number"]),
    "three numbers for a pair": ("[slope]\norigin = [0.0, 1.0, 2.0]", ["slope.origin", "[0.0, 1.0, 2.0]", "2"]),
    "date": ("end_time = 1979-05-27", ["end_time", "1979", "number"]),
    "NaN": ("gravity = nan", ["gravity", "nan", "finite"]),
    "NaN contact point": ("[contact]\npoint = nan", ["contact.point", "nan", "finite"]),
    "infinity": ("end_time = inf", ["end_time", "inf", "finite"]),
    "NaN in a pair": ("[slope]\norigin = [nan, 0.0]", ["slope.origin.0", "nan", "finite"]),
    "beyond a float": ("[beam]\nlength = 1" + "0" * 400, ["beam.length", "1000", "number"]),
    "negative length": ("[beam]\nlength = -1.0", ["beam.length", "-1.0", "greater than 0"]),
    "zero length": ("[beam]\nlength = 0", ["beam.length", "0", "greater than 0"]),
    "negative gravity": ("gravity = -9.8", ["gravity", "-9.8", "greater than or equal to 0"]),
    "negative regularization": (
        "[contact]\nregularization = [-0.01, 0.01]",
        ["contact.regularization.0", "-0.01", "greater than or equal to 0"],
    ),
    "restitution above one": (
        "[contact]\nrestitution = 1.01",
        ["contact.restitution", "1.01", "less than or equal to 1"],
    ),
    "negative restitution": (
        "[contact]\nrestitution = -0.1",
        ["contact.restitution", "-0.1", "greater than or equal to 0"],
    ),
    "too many modes": (
        f"[discretization]\nmodes = {MAX_MODES + 1}",
        ["discretization.modes", str(MAX_MODES + 1), str(MAX_MODES)],
    ),
    "too many elements": (
        f'[discretization]\nmethod = "fem"\nelements = {MAX_ELEMENTS + 1}',
        ["discretization.elements", str(MAX_ELEMENTS + 1), str(MAX_ELEMENTS)],
    ),
    "not TOML": ("end_time = = 1", ["scenario file", "not valid TOML", "line 1"]),
    "nested too deeply": ("end_time = " + "[" * 10_000, ["scenario file", "nested too deeply"]),
    "key with a line break": ('"grav\\nity" = 9.8', ["grav", "9.8", "gravity"]),
    "value with a line break": ('[beam]\nlength = "a\\nb"', ["beam.length", "number"]),
    "integer of 5000 digits": ("end_time = " + "9" * 5000, ["scenario file", "digits"]),
    "dotted keys too deep": ("beam.length" + ".a" * 10 + " = 1", ["beam.length", "number"]),
    "dotted keys far too deep": ("beam.length" + ".a" * 3000 + " = 1", ["scenario file", "20 parts"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line_with_key_value_and_what_is_allowed(name):
    text, parts = BAD[name]
    with pytest.raises(InputError) as error:
        Scenario.from_toml(text)
    message = one_line(error)
    assert len(message) < 400
    for part in parts:
        assert part in message


def test_missing_and_unreadable_files(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"# caf\xe9\n")
    for source, allowed in [
        (str(tmp_path / "missing.toml"), "built-in"),
        (str(tmp_path), "built-in"),
        (str(latin), "cannot be read"),
        ("x" * 5000, "built-in"),
    ]:
        with pytest.raises(InputError) as error:
            Scenario.load(source)
        message = one_line(error)
        assert source[:50] in message
        assert allowed in message


def test_unknown_builtin_names_the_known_ones():
    with pytest.raises(InputError, match=r"nowhere.*paper.*sticking"):
        Scenario.builtin("nowhere")


@pytest.mark.parametrize(
    ("override", "section", "key", "value"),
    [
        ("beam.length=2", "beam", "length", 2.0),
        (" beam . length = 2.5 ", "beam", "length", 2.5),
        ("contact.friction=frictionless", "contact", "friction", "frictionless"),
        ('contact.friction="modified-coulomb"', "contact", "friction", "modified-coulomb"),
        ("contact.enabled=false", "contact", "enabled", False),
        ("slope.origin=[0.25, -0.5]", "slope", "origin", (0.25, -0.5)),
        ("solver.baumgarte=[0, 0.0]", "solver", "baumgarte", (0.0, 0.0)),
        ("discretization.modes=3", "discretization", "modes", 3),
    ],
)
def test_overrides(override, section, key, value):
    assert getattr(getattr(Scenario.from_toml("", [override]), section), key) == value


def test_overrides_at_top_level_and_on_top_of_the_file():
    scenario = Scenario.from_toml("[beam]\nlength = 2.0\narea = 1e-3", ["end_time=0.5", "beam.length=3"])
    assert (scenario.end_time, scenario.beam.length, scenario.beam.area) == (0.5, 3.0, 1e-3)


@pytest.mark.parametrize(
    ("override", "parts"),
    [
        ("beam.length", ["beam.length", "section.key=value"]),
        ("=2", ["=2", "section.key=value"]),
        ("beam.=2", ["beam.=2", "section.key=value"]),
        ("beam.length.unit=m", ["beam.length.unit=m", "section.key=value"]),
        ("end_time.x=2", ["end_time.x=2", "end_time", "not a section"]),
        ("beam.lenght=2", ["beam.lenght", "2", "length"]),
        ("beams.length=2", ["beams", "beam"]),
        ("beam.length=long", ["beam.length", "'long'", "number"]),
        ("beam.length=", ["beam.length", "''", "number"]),
        ("beam\nlength", ["section.key=value"]),
        ("beam.length=" + "9" * 5000, ["beam.length"]),
        ("beam.length=2\ngravity = 0", ["beam.length", "gravity"]),
    ],
)
def test_bad_overrides(override, parts):
    with pytest.raises(InputError) as error:
        Scenario.from_toml("end_time = 1.0", [override])
    message = one_line(error)
    for part in parts:
        assert part in message


def test_sections_are_frozen():
    with pytest.raises(ValueError, match="frozen"):
        Scenario().beam.length = 2.0


def test_touching_the_slope_while_closing_is_legal():
    scenario = Scenario().replace(
        slope__origin=[0.0, 0.0],
        slope__angle=0.5,
        initial__angle=0.5,
        initial__angular_velocity=-2.0,
        end_time=0.01,
    )
    assert scenario.initial_gap == 0.0
    first = simulate(scenario).events[0]
    assert (first.time, first.kind.value) == (0.0, "impact")
    # the undeformed beam turns rigidly: the tip closes at 2 rad/s times 1 m
    assert first.normal_velocity == pytest.approx(-2.0, rel=1e-14)


def test_touching_the_slope_while_opening_stays_free():
    scenario = Scenario().replace(
        slope__origin=[0.0, 0.0],
        slope__angle=0.5,
        initial__angle=0.5,
        initial__angular_velocity=2.0,
        end_time=0.01,
    )
    history = simulate(scenario)
    assert history.events == []
    assert float(history["gap"].min()) >= 0.0


# Fuzzing: whatever comes in, nothing but InputError comes out -----------------------------------------------


def refused_in_one_line(read, *arguments):
    """The scenario, or None where the input was refused; any other exception passes through."""
    try:
        return read(*arguments)
    except InputError as error:
        message = str(error)
    assert len(message.splitlines()) == 1, message
    return None


INNER_KEYS = [key for section in PAPER.values() if isinstance(section, dict) for key in section]
KEYS = sorted({"nonsense", *PAPER, *INNER_KEYS})
NAMES = st.one_of(st.sampled_from(KEYS), st.text(max_size=8), st.integers())
LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.binary(max_size=4),
    st.dates(),
    st.sampled_from(["pin", "hub", "driven", "fem", "modal", "mean-axis", "spin-up", "spring"]),
    st.sampled_from([0, 1, 2, 1e300, -0.0]),
)
ANYTHING = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=4),
    max_leaves=12,
)


@settings(derandomize=True, max_examples=250, deadline=None)
@given(data=st.dictionaries(NAMES, ANYTHING, max_size=5))
@example(data={"beam": {"length": 10**400}})
@example(data={"a\nb": 1})
@example(data={"beam": {"a\r\nb": {}}})
@example(data={3: 4})
@example(data={"\ud800": 4})
def test_from_dict_raises_nothing_but_one_line(data):
    scenario = refused_in_one_line(Scenario.from_dict, data)
    assert scenario is None or Scenario.from_toml(scenario.to_toml()) == scenario


def nest(depth):
    data = {"a": 1}
    for _ in range(depth):
        data = {"a": data}
    return data


@pytest.mark.parametrize("depth", [10, 300, 900, 3000])
def test_deeply_nested_dicts(depth):
    for data in ({"beam": {"length": nest(depth)}}, {"beam": nest(depth)}, nest(depth)):
        with pytest.raises(InputError) as error:
            Scenario.from_dict(data)
        one_line(error)


TOML_PIECES = st.sampled_from([*"[]{}=.\n\"'#,", "beam", "length", "[beam]\n", "end_time = ", "1e400", "1_0"])


@settings(derandomize=True, max_examples=250, deadline=None)
@given(text=st.one_of(st.text(max_size=60), st.lists(st.one_of(TOML_PIECES, st.text(max_size=4))).map("".join)))
@example(text="a = 1\na = 2")
@example(text="beam.length = 1\n[beam]\narea = 2")
@example(text="\x00")
@example(text="end_time = 0x" + "f" * 5000)
def test_from_toml_raises_nothing_but_one_line(text):
    refused_in_one_line(Scenario.from_toml, text)


@settings(derandomize=True, max_examples=100, deadline=None)
@given(override=st.text(max_size=30) | st.lists(st.one_of(TOML_PIECES, st.sampled_from(KEYS))).map("".join))
def test_overrides_raise_nothing_but_one_line(override):
    refused_in_one_line(Scenario.from_toml, "", [override])
