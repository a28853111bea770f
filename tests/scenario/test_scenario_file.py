"""Scenario files: what follows other keys, the line of a fault, what may have been meant; the same from Python."""

import copy
import pickle
import tomllib

import pytest

from oblique_impact import InputError, Scenario, natural_frequencies, simulate
from oblique_impact.renders import export, render
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.scenario.sections import BeamSection, ContactSection, DiscretizationSection, SolverSection
from oblique_impact.scenario.toml import line_of
from oblique_impact.validation import compare, refine
from oblique_impact.validation.studies.design import AxisSection, SweepFile, load_plan, make_plan

NODAL = ("discretization.method=fem", "discretization.modes=0")

# What follows other keys ------------------------------------------------------------------------------------

CHANGES = [
    (),
    ("beam.length=2",),
    ("beam.length=2 m", "contact.point=1500 mm"),
    ("contact.point=0.15",),
    ("end_time=0.5", "gravity=0"),
    ("discretization.modes=4",),
    NODAL,
    (*NODAL, "beam.length=3"),
    (*NODAL, "solver.scheme=event"),
    (*NODAL, "discretization.frame=tangent"),
    ("discretization.method=fem", "discretization.modes=6"),
    ("solver.scheme=fixed-step",),
    ("solver.scheme=generalized-alpha", "discretization.frame=mean-axis"),
    ("root.kind=hub", "root.inertia=1 kg m^2"),
    ("beam.area=3e-4", "beam.second_moment=7e-9", "beam.tip_mass=0", "discretization.grading=1"),
]


def loaded(source: str, changes) -> Scenario | str:
    """The scenario, or the line that refuses it."""
    try:
        return Scenario.load(source, list(changes))
    except InputError as error:
        return str(error).partition(": ")[2] if str(error).startswith(source) else str(error)


@pytest.mark.parametrize("name", builtin_names())
def test_changes_mean_the_same_on_a_builtin_case_and_on_the_file_it_saved(tmp_path, name):
    file, again = tmp_path / "saved.toml", tmp_path / "again.toml"
    file.write_text(Scenario.builtin(name).to_toml())
    again.write_text(Scenario.load(str(file)).to_toml())
    assert file.read_text() == again.read_text()
    possible = 0
    for changes in CHANGES:
        expected = loaded(name, changes)
        assert loaded(str(file), changes) == expected, changes
        if isinstance(expected, Scenario):
            possible += 1
            keys = {key.replace(".", "__"): value for key, value in (c.split("=") for c in changes)}
            texts = {key: value for key, value in keys.items() if not value.replace(".", "").isdigit()}
            if texts == keys:  # replace takes values, not words of the command line
                assert Scenario.builtin(name).replace(**keys) == expected
                assert Scenario.load(str(file)).replace(**keys) == expected
            assert Scenario.from_toml(expected.to_toml()) == expected
    assert possible >= 5


def test_the_contact_point_stays_at_the_tip_unless_it_was_given():
    assert Scenario.from_toml("", ["beam.length=2"]).contact.point == 2.0
    assert Scenario.from_toml(Scenario().to_toml(), ["beam.length=2"]).contact.point == 2.0
    given = Scenario.from_toml("[contact]\npoint = 1.0")
    assert given == Scenario()
    for scenario in (given, Scenario.from_toml(given.to_toml()), pickle.loads(pickle.dumps(given))):
        assert scenario.replace(beam__length=2.0).contact.point == 1.0
    follows = pickle.loads(pickle.dumps(Scenario()))
    assert follows.replace(beam__length=2.0).replace(end_time=0.1).contact.point == 2.0
    assert Scenario(contact=ContactSection(mu_static=0.5), beam={"length": 2.0}).contact.point == 2.0


def test_the_resolved_file_is_complete_and_lists_what_was_not_given():
    found = tomllib.loads(Scenario.from_toml("[contact]\npoint = 0.5").to_toml())
    assert found["contact"]["point"] == 0.5
    assert (found["solver"]["scheme"], found["discretization"]["frame"]) == ("event", "tangent")
    assert found["derived"] == {"discretization.frame": "tangent", "solver.scheme": "event"}


def test_a_value_changed_by_hand_in_a_resolved_file_counts_as_given():
    text = Scenario().to_toml().replace("point = 1.0\n", "point = 0.5\n", 1)
    scenario = Scenario.from_toml(text)
    assert scenario.contact.point == 0.5
    assert scenario.replace(beam__length=2.0).contact.point == 0.5


@pytest.mark.parametrize(
    "table", ["derived = 3", '[derived]\n"beam.length" = 1.0', "[derived.contact]\npoint = 1.0"]
)
def test_a_senseless_table_of_derived_values_is_one_line(table):
    with pytest.raises(InputError, match=r"derived = .*should be a table of contact\.point"):
        Scenario.from_toml(table)


def test_the_full_nodal_model_takes_the_scheme_and_frame_that_march_it():
    for scenario in (
        Scenario.builtin("paper", [*NODAL]),
        Scenario.from_toml('[discretization]\nmethod = "fem"\nmodes = 0'),
        Scenario(discretization={"method": "fem", "modes": 0}),
        Scenario(discretization=DiscretizationSection(method="fem", modes=0)),
        Scenario().replace(discretization__method="fem", discretization__modes=0),
        Scenario.from_toml(Scenario().to_toml(), [*NODAL]),
    ):
        assert (scenario.solver.scheme, scenario.discretization.frame) == ("generalized-alpha", "mean-axis")
        back = scenario.replace(discretization__modes=4)
        assert (back.solver.scheme, back.discretization.frame) == ("event", "tangent")
    kept = Scenario.builtin("elastic-stop").replace(discretization__modes=4)  # there they are given
    assert (kept.solver.scheme, kept.discretization.frame) == ("generalized-alpha", "mean-axis")


# The line of a fault ----------------------------------------------------------------------------------------

FILE = """\
# a beam
end_time = 0.5

[beam]
length = 2.0   # m
"area" = [
    [0.0, 3e-4],
    [2.0, 2e-4]
]
# lenght = 3
[contact]
mu_static = 0.1
[ slope ]
origin = [0.3, 0.0]
[discretization]
method = "fem"
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "key"),
    [
        ("length = 2.0", "lenght = 2.0", 5, "beam.lenght = 2.0"),
        ("end_time = 0.5", "end_time = 0.0", 2, "end_time = 0.0"),
        ("    [2.0, 2e-4]", "    [2.0, 2e-4, 1]", 6, "beam.area = "),
        ("[contact]", "[contcat]", 11, "contcat = "),
        ("mu_static = 0.1", "mu_static = 0.1\nmu_kinetic = 0.1\npoint = 3.0", 14, "contact.point = 3.0"),
        ("mu_static = 0.1", "mu_static = 0.1", 12, "contact.mu_static = 0.1"),
        ("origin = [0.3, 0.0]", "origin = [0.3, true]", 14, "slope.origin.1 = True"),
        ("origin = [0.3, 0.0]", 'origin = [0.3, "1 kg"]', 14, "slope.origin = "),
        ('method = "fem"', 'method = "fme"', 16, "discretization.method = 'fme'"),
        ("end_time = 0.5", "initial.angle = 18", 2, "initial.angle = 18"),
        ("end_time = 0.5", "initial = {angle = 18}", 2, "initial.angle = 18"),
        ("length = 2.0", "length = = 2.0", 5, "not valid TOML"),
        ("length = 2.0", "length = 2.0\nlength = 3.0", 6, "not valid TOML"),
    ],
)
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_a_fault_of_a_file_names_the_file_and_the_line(tmp_path, old, new, line, key, ending):
    file = tmp_path / "beam.toml"
    assert FILE.count(old) == 1
    file.write_bytes(FILE.replace(old, new).replace("\n", ending).encode())
    with pytest.raises(InputError) as error:
        Scenario.load(str(file))
    assert str(error.value).startswith(f"{file}, line {line}: {key}")


def test_a_change_has_no_line_of_the_file(tmp_path):
    file = tmp_path / "beam.toml"
    file.write_text("[beam]\nlength = 2.0\n")
    with pytest.raises(InputError) as error:
        Scenario.load(str(file), ["beam.length=-1"])
    assert str(error.value).startswith("beam.length = -1: ")


def test_the_last_of_several_lists_of_tables_has_its_own_line():
    text = '[[axes]]\nkey = "a"\n[[axes]]\nkey = "b"\nvalues = [1]\n[[latin.axes]]\nkey = "c"\n'
    assert [line_of(key, text) for key in ("axes.0.key", "axes.1.key", "axes.1.values.0")] == [2, 4, 5]
    assert line_of("axes.1.count", text) == 3
    assert line_of("latin.axes.0.key", text) == 7
    assert line_of("nothing", text) is None


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ('[[axes]]\nkey = "slope.angel"\nvalues = [0.1]', 2, "did you mean slope.angle?"),
        ('[[axes]]\nkye = "slope.angle"\nvalues = [0.1]', 2, "did you mean key?"),
        ('quantities = ["impulze"]\n[[axes]]\nkey = "gravity"\nvalues = [1]', 1, "did you mean impulse?"),
        ('scenario = "papr"\n[[axes]]\nkey = "gravity"\nvalues = [1]', 1, "did you mean paper?"),
        ("[[axes]]\nkey = = 3", 2, "not valid TOML"),
    ],
)
def test_a_fault_of_a_sweep_file_names_the_file_and_the_line(tmp_path, text, line, words):
    file = tmp_path / "sweep.toml"
    file.write_text(text)
    with pytest.raises(InputError) as error:
        load_plan(file)
    assert str(error.value).startswith(f"{file}, line {line}: ")
    assert words in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_sweeps_take_texts_with_units():
    rows = 'range = ["0 deg", "18 deg"]\ncount = 3', 'values = ["0 deg", "9 deg", 0.3141592653589793]'
    for given in rows:
        plan = make_plan(f'[[axes]]\nkey = "slope.angle"\n{given}')
        assert [list(run.labels.values())[1] for run in plan.runs] == pytest.approx(
            [0.0, 0.15707963267948966, 0.3141592653589793]
        )
    cube = '[latin_hypercube]\nsamples = 2\nseed = 1\n[[latin_hypercube.axes]]\nkey = "beam.length"\n'
    plan = make_plan(f'{cube}range = ["900 mm", 1.1]')
    assert all(0.9 <= run.labels["beam.length"] <= 1.1 for run in plan.runs)
    table = make_plan('[table]\nkeys = ["end_time", "gravity"]\nrows = [["100 ms", "981 cm/s^2"]]')
    assert list(table.runs[0].labels.values())[1:] == [0.1, 9.81]
    changed = make_plan('changes = {"beam.length" = "2000 mm"}\n[[axes]]\nkey = "end_time"\nvalues = ["0.1 s"]')
    assert changed.runs[0].scenario.beam.length == 2.0
    with pytest.raises(InputError, match=r"slope\.angle = '1 m'"):  # keys of one axis have one unit
        make_plan('[[axes]]\nkeys = ["beam.length", "slope.angle"]\nrange = ["1 m", "2 m"]\ncount = 2')


# What may have been meant -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "meant"),
    [
        ("beam.lenght=2", "did you mean length?"),
        ("bema.length=2", "did you mean beam?"),
        ("end_tim=2", "did you mean end_time?"),
        ("slope.mu_static=2", "did you mean contact.mu_static?"),
        ("mu_static=2", "did you mean contact.mu_static?"),
        ("contact.normal=sprng", "did you mean 'spring'?"),
        ("root.kind=drivn", "did you mean 'driven'?"),
        ("discretization.method=modl", "did you mean 'modal'?"),
        ("solver.scheme=generalised-alpha", "did you mean 'generalized-alpha'?"),
    ],
)
def test_the_most_similar_word_is_offered(change, meant):
    with pytest.raises(InputError) as error:
        Scenario.builtin("paper", [change])
    assert meant in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_nothing_is_offered_where_nothing_is_similar():
    with pytest.raises(InputError) as error:
        Scenario.builtin("paper", ["beam.qqq=2"])
    assert "did you mean" not in str(error.value)


@pytest.mark.parametrize("make", [Scenario.builtin, Scenario.load])
def test_names_of_builtin_scenarios_are_offered(make):
    with pytest.raises(InputError, match="did you mean sticking"):
        make("stiking")


# The same from Python ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "start"),
    [
        (lambda: Scenario(beam={"lenght": 2}), "beam.lenght = 2: unknown key; did you mean length?"),
        (lambda: Scenario(bema={}), "bema = {}: unknown key; did you mean beam?"),
        (lambda: Scenario(derived={}), "derived = {}: unknown key"),
        (lambda: Scenario(contact={"mu_static": 0.1}), "contact.mu_static = 0.1: should be at least"),
        (lambda: Scenario(beam=3), "beam = 3: should be"),
        (lambda: Scenario.model_validate({"beam": {"lenght": 2}}), "beam.lenght = 2: unknown key"),
        (lambda: Scenario.from_dict(3), "Scenario = 3: should be"),
        (lambda: Scenario().replace(beam__lenght=2), "beam.lenght = 2: unknown key; did you mean length?"),
        (lambda: Scenario().replace(bema__length=2), "bema = {'length': 2}: unknown key; did you mean beam?"),
        (lambda: Scenario().replace(end_time__x=2), "end_time__x: end_time is not a section"),
        (lambda: BeamSection(lenght=2), "lenght = 2: unknown key; did you mean length?"),
        (lambda: BeamSection(length="12 kg"), "length = '12 kg': should be in m, not in kg"),
        (lambda: setattr(Scenario().beam, "length", 2.0), "length = 2.0: scenarios are frozen"),
        (lambda: SweepFile(axis=[]), "axis = []: unknown key; did you mean axes?"),
        (lambda: AxisSection(vlues=[1]), "vlues = [1]: unknown key; did you mean values?"),
        (lambda: simulate("paper"), "simulate: scenario = 'paper': should be a Scenario"),
        (lambda: natural_frequencies("paper", [0.0]), "natural_frequencies: scenario = 'paper': should be"),
        (lambda: refine("paper", modes=[2, 3, 4]), "refine: scenario = 'paper': should be a Scenario"),
        (lambda: compare(Scenario(), Scenario()), "compare: history = Scenario("),
        (lambda: render(Scenario(), "a.png"), "render: history = Scenario("),
        (lambda: export(Scenario(), "a.pvd"), "export: history = Scenario("),
    ],
    ids=range(21),
)
def test_a_bad_argument_is_the_same_line_as_on_the_command_line(make, start):
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value).startswith(start)
    assert len(str(error.value).splitlines()) == 1


def test_scenarios_can_be_copied_pickled_and_validated_again():
    scenario = Scenario(beam=BeamSection(length=2.0), solver=SolverSection(tolerance=1e-8))
    for again in (
        copy.copy(scenario),
        copy.deepcopy(scenario),
        pickle.loads(pickle.dumps(scenario)),
        scenario.model_copy(),
        Scenario.model_validate(scenario),
        Scenario.model_validate(scenario.model_dump()),
        Scenario(**dict(scenario)),
    ):
        assert again == scenario
        assert hash(again) == hash(scenario)
