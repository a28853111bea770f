"""What is said about the keys of a scenario: unit, meaning and range of each, once, in schema, file and words."""

from __future__ import annotations

import json
import re
import tomllib
from importlib import resources

import fastjsonschema
import pytest

from oblique_impact import InputError, Scenario, scenario_schema
from oblique_impact.command_line.application import main
from oblique_impact.scenario import user_defined
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.scenario.schema import comment_of, key_schemas, words_of
from oblique_impact.scenario.toml import flat_keys, set_key

# the unit of each key, written down a second time
UNITS = {
    "s": "end_time beam.kelvin_voigt root.spin_up_time solver.free_step solver.contact_step "
    "solver.output_interval",
    "m": "beam.length beam.outer_fibre beam.section.width beam.section.height beam.section.diameter "
    "beam.section.thickness beam.section.flange_thickness beam.section.web_thickness "
    "root.hub_radius slope.origin slope.extent contact.point "
    "discretization.nodes",
    "rad": "initial.angle slope.angle",
    "rad/s": "root.spin_rate initial.angular_velocity",
    "1/s": "beam.mass_proportional solver.baumgarte",
    "m/s^2": "gravity",
    "m^2": "beam.area",
    "m^4": "beam.second_moment",
    "kg/m^3": "beam.density",
    "Pa": "beam.youngs_modulus",
    "kg": "beam.tip_mass",
    "kg m^2": "root.inertia",
    "N m": "root.torque",
    "N/m": "contact.stiffness",
    "s/m": "contact.damping",
    "m/s": "contact.regularization",
    "1": "beam.modal_damping_ratio contact.restitution contact.mu_static contact.mu_kinetic discretization.modes "
    "discretization.elements discretization.grading solver.tolerance solver.rho_infinity",
}


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


def test_every_key_has_its_unit_and_a_meaning():
    data = Scenario().model_dump()
    parameters = {f"parameters.{part}" for part in data.pop("parameters")}
    schemas = key_schemas()
    assert schemas.keys() == flat_keys(data).keys() | parameters
    expected = {key: unit for unit, keys in UNITS.items() for key in keys.split()}
    assert {key: schema["unit"] for key, schema in schemas.items() if "unit" in schema} == expected
    for key, schema in schemas.items():
        assert len(schema["description"]) >= 10, key
        assert "default" in schema or key == "contact.point"


@pytest.mark.parametrize("name", builtin_names())
def test_the_schema_takes_the_built_in_cases_and_their_resolved_files(valid, name):
    text = (resources.files("oblique_impact.scenario") / "cases" / f"{name}.toml").read_text(encoding="utf-8")
    assert valid(tomllib.loads(text))
    assert valid(tomllib.loads(Scenario.builtin(name).to_toml()))


def test_the_schema_takes_what_is_taken(valid):
    for path, value in [
        ("beam.density", "8 g cm^-3"),
        ("beam.area", "3 cm^2"),
        ("beam.mass_proportional", "2 1/s"),
        ("slope.angle", "18°"),
        ("slope.origin", ["300 mm", 0]),
        ("discretization.mesh", "beam.msh"),
        ("parameters.friction", {"mu": 0.3}),
    ]:
        assert valid(data_of(path, value)), path
    table = [["0 mm", "3 cm^2"], [1.0, 2e-4]]
    assert valid({"beam": {"area": table}, "discretization": {"method": "fem", "nodes": [0.0, 1.0]}})
    for schema in key_schemas().values():  # a default is a value
        if "default" in schema:
            fastjsonschema.validate(schema, schema["default"])


REFUSED = [
    *[("gravity", value) for value in (-1.0, True, "9.8", "fast", [9.8], 1e7)],
    ("end_time", 0.0),
    ("end_tim", 1.0),
    ("beam", 3.0),
    ("beam.lenght", 2.0),
    ("beam.length", 1e31),
    ("beam.area", 0.0),
    ("beam.area", [[0.0, 1e-4]]),
    ("beam.area", [[0.0, 1e-4], [1.0, 1e-4, 2.0]]),
    ("root.kind", "pins"),
    ("slope.origin", [0.3]),
    ("slope.origin", [0.3, True]),
    ("slope.extent", 1.0),
    ("contact.enabled", 1),
    ("contact.friction", "stribek"),
    ("discretization.modes", 2.5),
    ("discretization.modes", 101),
    ("discretization.mesh", 3),
    ("parameters.friction", {"mu": "large"}),
    ("parameters.friction", 0.3),
    ("derived", {"beam.length": 1.0}),
]


@pytest.mark.parametrize(("path", "value"), REFUSED, ids=[f"{path}={value}" for path, value in REFUSED])
def test_the_schema_refuses_what_is_refused(valid, path, value):
    data = data_of(path, value)
    assert not valid(data)
    if path != "derived":
        with pytest.raises(InputError, match=re.escape(path)) as error:
            Scenario.from_dict(data)
        assert len(str(error.value).splitlines()) == 1


def test_bounds_in_words_are_those_of_the_models(valid):
    """What the words exclude is refused, by the schema too, and the bound itself is what the sign says."""
    checked = 0
    for path, schema in key_schemas().items():
        for sign, text in re.findall(r"([<>]=?) (-?[\d.e-]+)", words_of(schema)):
            bound = float(text)
            step = 1.0 if words_of(schema).startswith("whole") else abs(bound) * 1e-6 + 1e-9
            value = bound if "=" not in sign else bound + (step if "<" in sign else -step)
            value = int(value) if step == 1.0 else value
            data = data_of(path, [value, value] if schema.get("type") == "array" else value)
            assert not valid(data), path
            with pytest.raises(InputError, match=re.escape(path)):
                Scenario.from_dict(data)
            checked += 1
    assert checked > 40


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("beam.length", "length of the undeformed axis (number in m, > 0)"),
        ("beam.area", "area of the cross-section (number in m^2, > 0, or a table of pairs [x, value])"),
        ("beam.modal_damping_ratio", "damping ratio of each elastic mode (number, >= 0, < 1)"),
        ("discretization.elements", "number of finite elements (whole number, >= 1, <= 4096)"),
        ("slope.origin", "a point of the slope, [x, y] from the axis of the root (two numbers in m)"),
        ("contact.enabled", "whether the slope is there at all (true, false)"),
        ("contact.normal", 'a rigid stop, an elastic one, or a user-defined contact law ("rigid", "spring")'),
        (
            "parameters.friction",
            "numbers of the friction law that contact.friction names (table of numbers by name)",
        ),
    ],
)
def test_the_words_about_a_key(path, words):
    assert comment_of(key_schemas()[path]) == words
    section, _, key = path.partition(".")
    assert scenario_schema()["properties"][section]["properties"][key]["description"] == words


def test_a_resolved_file_has_each_key_below_its_comment():
    lines = Scenario().to_toml().splitlines()
    duration = lines.index("end_time = 1.0")
    assert lines[duration - 1] == "# duration of the run (number in s, > 0)"
    for path, schema in key_schemas().items():
        if not path.startswith(("parameters.", "beam.section.")):
            place = lines.index(f"# {comment_of(schema)}")
            assert lines[place + 1].startswith(f"{path.rpartition('.')[2]} = ")


def test_a_part_that_only_this_program_knows_is_not_in_the_schema(monkeypatch):
    """Editors check files for every program; the gallery registers parts while the reference is built."""
    monkeypatch.setattr(user_defined, "_REGISTERED", {("friction_laws", "of-this-program"): object})
    assert "of-this-program" in user_defined.names("friction_laws")
    assert "of-this-program" not in json.dumps(scenario_schema())


def test_the_command_prints_and_writes_the_schema(capsys, tmp_path):
    def call(*arguments: str) -> str:
        with pytest.raises(SystemExit) as end:
            main(["schema", *arguments])
        assert end.value.code == 0
        return capsys.readouterr().out

    file = tmp_path / "new" / "schema.json"
    assert json.loads(call()) == scenario_schema()
    assert call("--out", str(file)) == f"schema: {file}\n"
    assert json.loads(file.read_text(encoding="utf-8")) == scenario_schema()
    assert [path.name for path in file.parent.iterdir()] == ["schema.json"]
    with pytest.raises(InputError, match=r"--out .*: cannot be written: ") as error:
        scenario_schema(tmp_path)
    assert len(str(error.value).splitlines()) == 1
