"""Unit, meaning and range of each key of a scenario, in schema, file and words."""

from __future__ import annotations

import json
import re
import tomllib

import fastjsonschema
import pytest

from oblique_impact import InputError, Scenario, scenario_schema
from oblique_impact.scenario.comments import comment_of
from oblique_impact.scenario.scenario import builtin_names, builtin_text
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.toml import flat_keys, set_key

# the unit of each key, written down a second time
UNITS = {
    "s": "end_time beam.kelvin_voigt root.spin_up_time solver.free_step solver.contact_step "
    "solver.output_interval",
    "m": "beam.length beam.outer_fibre beam.section.width beam.section.height beam.section.diameter "
    "beam.section.thickness beam.section.flange_thickness beam.section.web_thickness "
    "root.hub_radius slope.origin slope.extent contact.point discretization.nodes "
    "initial.place initial.deflection initial.position",
    "rad": "initial.angle slope.angle base.direction",
    "rad/s": "root.spin_rate initial.angular_velocity",
    "1/s": "beam.mass_proportional solver.baumgarte",
    "m/s^2": "gravity base.acceleration base.table",
    "Hz": "base.frequency",
    "Hz/s": "base.sweep_rate",
    "m^2": "beam.area",
    "m^4": "beam.second_moment",
    "kg/m^3": "beam.density",
    "Pa": "beam.youngs_modulus",
    "kg": "beam.tip_mass",
    "kg m^2": "root.inertia",
    "N": "initial.force",
    "N m": "root.torque",
    "N m/rad": "root.stiffness",
    "N m s/rad": "root.damping",
    "N/m": "contact.stiffness",
    "s/m": "contact.damping",
    "N s/m": "contact.linear_damping",
    "m/s": "contact.regularization initial.velocity",
}
PLAIN = (
    "beam.modal_damping_ratio contact.restitution contact.mu_static contact.mu_kinetic discretization.modes "
    "contact.grid discretization.elements discretization.grading solver.tolerance solver.rho_infinity"
)


@pytest.fixture(scope="module")
def valid():
    """Whether an editor takes the data of a scenario file."""
    check = fastjsonschema.compile(scenario_schema())

    def judge(data: dict) -> bool:
        try:
            check(data)
        except fastjsonschema.JsonSchemaValueException:
            return False
        return True

    return judge


def data_of(path: str, value) -> dict:
    data: dict = {}
    set_key(data, path.split("."), value, path)
    return data


def test_every_key_has_its_unit_a_meaning_and_a_default():
    schemas = key_schemas()
    assert schemas.keys() == flat_keys(Scenario().model_dump()).keys()
    expected = {key: unit for unit, keys in {**UNITS, "1": PLAIN}.items() for key in keys.split()}
    assert {key: schema["unit"] for key, schema in schemas.items() if "unit" in schema} == expected
    for key, schema in schemas.items():
        assert len(schema["description"]) >= 10, key
        assert "default" in schema, key


def test_every_key_refuses_units_but_its_own():
    for unit, keys in UNITS.items():
        for path in keys.split():
            text = "1 kg^3"
            value = [text, text] if key_schemas()[path].get("type") == "array" else text
            with pytest.raises(InputError, match=rf"^{re.escape(path)} = .*should be in {re.escape(unit)}"):
                Scenario.from_dict(data_of(path, value))


@pytest.mark.parametrize("name", builtin_names())
def test_the_schema_takes_the_built_in_cases_and_their_resolved_files(valid, name):
    assert valid(tomllib.loads(builtin_text(name)))
    assert valid(tomllib.loads(Scenario.builtin(name).to_toml()))


def test_the_schema_takes_what_is_taken(valid):
    for path, value in [
        ("beam.density", "8 g cm^-3"),
        ("beam.mass_proportional", "2 1/s"),
        ("slope.angle", "18°"),
        ("slope.origin", ["300 mm", 0]),
        ("discretization.mesh", "beam.msh"),
        ("beam.area", [["0 mm", "3 cm^2"], [1.0, 2e-4]]),
        ("discretization.nodes", [0.0, 1.0]),
    ]:
        assert valid(data_of(path, value)), path


REFUSED = [
    *[("gravity", value) for value in (-1.0, True, "9.8", [9.8], 1e7)],
    ("beam", 3.0),
    ("beam.lenght", 2.0),
    ("beam.area", [[0.0, 1e-4]]),
    ("root.kind", "pins"),
    ("slope.origin", [0.3]),
    ("discretization.modes", 2.5),
    ("discretization.modes", 101),
]


@pytest.mark.parametrize(("path", "value"), REFUSED, ids=[f"{path}={value}" for path, value in REFUSED])
def test_the_schema_refuses_what_is_refused(valid, path, value):
    data = data_of(path, value)
    assert not valid(data)
    with pytest.raises(InputError, match=re.escape(path)):
        Scenario.from_dict(data)


def test_a_file_says_meaning_unit_and_range_of_a_key():
    words = comment_of(key_schemas()["beam.area"])
    assert words == "area of the cross-section (number in m^2, > 0, or a table of pairs [x, value])"
    assert f"# {words}\narea = " in Scenario().to_toml()


def test_the_command_prints_and_writes_the_schema(cli, tmp_path):
    file = tmp_path / "new" / "schema.json"
    assert json.loads(cli("schema")[1]) == scenario_schema()
    assert cli("schema", "--out", file) == (0, f"schema: {file}\n", "")
    assert json.loads(file.read_text(encoding="utf-8")) == scenario_schema()
    with pytest.raises(InputError, match=r"--out .*: cannot be written: "):
        scenario_schema(tmp_path)
