"""Units of the scenario's keys: texts with a unit become SI numbers to the last digit, wherever there is one."""

import math
import tomllib
from fractions import Fraction

import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.scenario.materials import MATERIALS
from tests.refusals import refused_in_one_line

INCH = Fraction("0.0254")


def exact(*factors) -> float:
    return float(math.prod(map(Fraction, factors)))


# SI brochure, 9th edition: prefixes and derived units; a degree is pi/180 rad.  NIST Special Publication 811,
# appendix B: a pound is 0.45359237 kg, an inch 0.0254 m, standard gravity 9.80665 m/s2
TEXTS = [
    ("beam.length", "12 mm", 0.012),
    ("beam.length", "1.2e3mm", 1.2),
    ("beam.area", "314 mm²", 3.14e-4),
    ("beam.second_moment", "7850 mm^4", 7.85e-9),
    ("beam.second_moment", "0.785 cm4", 7.85e-9),
    ("beam.density", "8 g cm^-3", 8000.0),
    ("beam.density", "8 g·cm⁻³", 8000.0),
    ("beam.youngs_modulus", "70 kN/mm^2", 70e9),
    ("beam.kelvin_voigt", "10 µs", 1e-5),
    ("beam.mass_proportional", "2 1/s", 2.0),
    ("gravity", "981 cm/s**2", 9.81),
    ("end_time", "300 ms", 0.3),
    ("slope.angle", "18 deg", math.pi / 10),
    ("initial.angle", "45°", math.pi / 4),
    ("initial.angular_velocity", "-30 rpm", -math.pi),
    ("contact.stiffness", "1 kN/mm", 1e6),
    ("solver.output_interval", "0.1 ms", 1e-4),
    ("end_time", "0.5 sec", 0.5),
    ("end_time", "1.5metre s / metre", 1.5),
    ("beam.length", "10 inches", 0.254),
    ("beam.youngs_modulus", "1e7 psi", exact("1e7", "0.45359237", "9.80665", 1 / INCH**2)),
    ("beam.youngs_modulus", "700 kbar", 70e9),
    ("beam.youngs_modulus", "70000 N / mm2", 70e9),
    ("beam.density", "0.1 lb/in3", exact("0.1", "0.45359237", 1 / INCH**3)),
    ("beam.density", "2.7 t/m^3", 2700.0),
    ("beam.density", "2700 kg m-3", 2700.0),
    ("contact.stiffness", "10 lbf/in", exact(10, "0.45359237", "9.80665", 1 / INCH)),
    ("beam.mass_proportional", "2/s", 2.0),
    ("gravity", "1 g_n", 9.80665),
    ("gravity", "9.81 m/(s s)", 9.81),
    ("initial.angular_velocity", "0.5 rev/s", math.pi),
]


def value_of(scenario: Scenario, path: str):
    for name in path.split("."):
        scenario = getattr(scenario, name)
    return scenario


@pytest.mark.parametrize(("path", "text", "number"), TEXTS)
def test_a_text_with_a_unit_is_the_si_number_everywhere(path, text, number):
    section, _, key = path.rpartition(".")
    sprung = key == "stiffness"  # a rigid stop has none
    other = {"normal": "spring"} if sprung else {}
    line = "contact.normal = 'spring'" if sprung else ""
    made = [
        Scenario.from_toml("", [f"{path}={text}", *(["contact.normal=spring"] if sprung else [])]),
        Scenario.from_toml(f'{path} = "{text}"\n{line}'),
        Scenario(**({section: {key: text} | other} if section else {key: text})),
        Scenario(contact=other).replace(**{path.replace(".", "__"): text}),
    ]
    for scenario in made:
        assert value_of(scenario, path) == number
        found = tomllib.loads(scenario.to_toml())
        assert (found[section] if section else found)[key] == number  # plain SI numbers in the resolved file


#: kg/m^3 and Pa, of ASM Handbook, vol. 1 and 2 (1990): plain carbon steel, 304, 1100, Ti-6Al-4V, C26000, C11000;
#: the yield strength of A36, 304, 6061-T6, Ti-6Al-4V, C26000 and C11000, both annealed
HANDBOOK = {
    "steel": (7850.0, 207e9, 250e6),
    "stainless-steel": (8000.0, 193e9, 205e6),
    "aluminium": (2710.0, 69e9, 276e6),
    "titanium": (4430.0, 114e9, 830e6),
    "brass": (8530.0, 110e9, 75e6),
    "copper": (8930.0, 117e9, 69e6),
}


def test_materials_are_those_of_another_handbook():
    """To 1.5 % in density, 4 % in the modulus, which is rounded differently, and 15 % in the strength."""
    assert set(HANDBOOK) == set(MATERIALS)
    for name, (density, modulus, strength) in HANDBOOK.items():
        beam = Scenario.from_dict({"beam": {"material": name}}).beam
        assert beam.density == pytest.approx(density, rel=0.015), name
        assert beam.youngs_modulus == pytest.approx(modulus, rel=0.04), name
        assert MATERIALS[name].yield_strength == pytest.approx(strength, rel=0.15), name


def test_a_material_or_a_shape_that_is_set_takes_the_place_of_the_numbers_it_gives(tmp_path):
    """Of a case and of a file; numbers that are set besides are still refused, see `test_consistency`."""
    section = 'beam.section={shape="rectangle", width="20 mm", height="1 mm"}'
    (tmp_path / "own.toml").write_text("[beam]\narea = 1e-4\ndensity = 1000.0\nkelvin_voigt = 1e-4\n", "utf-8")
    for source in ("shaken", str(tmp_path / "own.toml")):
        beam = Scenario.load(source, ["beam.material=aluminium", section]).beam
        assert (beam.density, beam.area) == (2700.0, pytest.approx(2e-5))
        assert beam.kelvin_voigt == Scenario.load(source).beam.kelvin_voigt
        assert Scenario.load(source, [section]).beam.density == Scenario.load(source).beam.density
    with pytest.raises(InputError, match="give one of the two"):
        Scenario.load("shaken", ["beam.material=steel", "beam.density=7000"])


def test_texts_in_pairs_and_in_tables_over_x():
    scenario = Scenario.from_dict(
        {
            "slope": {"origin": ["300 mm", 0]},
            "contact": {"friction": "modified-coulomb", "regularization": ("1 mm/s", "2 cm/s")},
            "solver": {"baumgarte": ["20 1/s", "1 1/ms"]},
            "beam": {"tip_mass": "50 g", "area": [["0 mm", "3 cm^2"], [0.5, 2e-4], ["1000 mm", "100 mm^2"]]},
            "discretization": {"method": "fem"},
        }
    )
    assert scenario.beam.tip_mass == 0.05
    assert scenario.slope.origin == (0.3, 0.0)
    assert scenario.contact.regularization == (1e-3, 2e-2)
    assert scenario.solver.baumgarte == (20.0, 1000.0)
    assert scenario.beam.area == ((0.0, 3e-4), (0.5, 2e-4), (1.0, 1e-4))


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("slope.angle", "18", ['"18 deg"', "rad"]),
        ("slope.angle", "12 mm", ["in rad or deg, not in mm"]),
        ("slope.angle", "400 deg", ["less than or equal"]),
        ("beam.length", "12 furlong", ["'furlong' is no unit", "known: m, g, s"]),
        ("beam.length", "12 (m", ["no unit"]),
        ("beam.length", '"12"', ["a number in m", '"12 m"']),
        ("beam.youngs_modulus", '"2.1e11"', ["a number in Pa", '"2.1e11 Pa"']),
        ("beam.length", "1e999 m", ["finite"]),
        ("beam.length", "-12 mm", ["greater than 0"]),
        ("initial.angular_velocity", "2 Hz", ["in rad/s, not in Hz"]),
        ("slope.origin", '["300 mm", "1 kg"]', ["in m, not in kg", "entry 2", "1 kg"]),
        ("contact.mu_static", "1 m", ["a number"]),
        # nothing behind a number is left out
        ("beam.length", '"5 cm#5"', ["'cm#5' is no unit"]),
        ("beam.length", "5 cm; 5", ["'cm; 5' is no unit"]),
        ("beam.length", "5 m 2", ["'m 2' is no unit"]),
        ("beam.length", "5 m @", ["'m @' is no unit"]),
        ("beam.length", "5 m.", ["'m.' is no unit"]),
        ("beam.length", "1,5 m", ["with a decimal point"]),
        ("beam.length", "1_000 m", ["without separators"]),
        ("beam.length", "1 000 m", ["without separators"]),
        ("beam.length", "1e-999999999 kg", ["in m, not in kg"]),
        ("beam.length", f'"{"1" * 5000} m"', ["a number in m"]),
        # what people write
        ("root.torque", "5 Nm", ["'Nm' is no unit", 'did you mean "N m"?']),
        ("root.torque", "5 kN-m", ['did you mean "kN m"?']),
        ("root.torque", "5 lb-ft", ['did you mean "lbf ft"?']),
        ("root.torque", "5 N.mm", ['did you mean "N mm"?']),
        ("root.inertia", "5 kgm2", ['did you mean "kg m2"?']),
        ("beam.length", "'5\"'", ['did you mean "in"?']),
        ("beam.youngs_modulus", "70 GPA", ['did you mean "GPa"?']),
        ("beam.youngs_modulus", "70e3 MPA", ['"MPa"']),
        ("beam.youngs_modulus", "70 Pas", ["'Pas' is no unit"]),
        ("beam.youngs_modulus", "1e7 lb/in^2", ["in Pa, not in lb/in^2", 'did you mean "lbf/in^2"?']),
        ("contact.stiffness", "1 KN/m", ['did you mean "kN/m"?']),
        ("initial.angular_velocity", "30 RPM", ['did you mean "rpm"?']),
        ("gravity", "1 g", ["in m/s^2, not in g", 'did you mean "g_n"?']),
    ],
)
def test_what_is_no_value_of_the_unit_is_one_line(path, value, words):
    with refused_in_one_line(*words, start=f"{path} = "):
        Scenario.from_toml("", [f"{path}={value}"])
