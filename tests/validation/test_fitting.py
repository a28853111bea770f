"""Keys found from measured data: made data with noise, what sensors read, faulty files."""

import json
import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom
from scipy.stats import t as student

from oblique_impact import InputError, Scenario, frequencies_at_rest, simulate
from oblique_impact.history.sensors import sensor_reading
from oblique_impact.renders.exports import export
from oblique_impact.validation import fit
from oblique_impact.validation.studies.fitting.measured import read_measured
from oblique_impact.validation.studies.parallel import map_parallel
from tests.refusals import refused_in_one_line

# a steel strip, clamped, falls onto an elastic stop 2 mm below it, twice in a tenth of a second
STRIP = Scenario.builtin(
    "shaken",
    [
        *("base.acceleration=0", "initial.angle=0", "slope.origin=[0.25,-0.002]", "slope.angle=0", "end_time=0.1"),
        *("discretization.modes=3", "solver.output_interval=1e-3", "beam.kelvin_voigt=1e-3"),
    ],
)
KEYS = ("beam.kelvin_voigt", "contact.stiffness")
GUESS = STRIP.replace(beam__kelvin_voigt=5e-4, contact__stiffness=1.5e4)
TIMES = np.linspace(2e-3, 0.1, 50)


def written(path, header, *columns):
    """A file of measured data."""
    rows = "".join(",".join(map(repr, map(float, row))) + "\n" for row in zip(*columns, strict=True))
    path.write_text(f"# made data\n{header}\n{rows}", encoding="utf-8-sig")  # as a spreadsheet does
    return path


def repetition(task):
    """Fit the displacement of the strip with the noise of a seed; the results."""
    path, seed, exact = task
    noise = 2e-5 * np.random.default_rng(seed).standard_normal(TIMES.size)
    data = written(path / f"{seed}.csv", "time [ms], displacement@200 mm [mm]", 1e3 * TIMES, 1e3 * (exact + noise))
    return fit(GUESS, data, vary=KEYS, starts=1, workers=1)


@pytest.fixture(scope="module")
def exact():
    return sensor_reading(simulate(STRIP), "displacement", 0.2, TIMES)


def misses(results):
    """How often the true value of each key is outside of its interval."""
    return [
        sum(not result[key].low <= STRIP.value_of(key) <= result[key].high for result in results) for key in KEYS
    ]


@pytest.mark.slow
def test_95_of_100_intervals_hold_the_true_value(tmp_path, exact):
    results = map_parallel(repetition, [(tmp_path, seed, exact) for seed in range(100)])
    for missed in misses(results):
        assert binom.ppf(0.01, 100, 0.05) <= missed <= binom.ppf(0.99, 100, 0.05)


def test_made_data_give_their_keys_back_and_a_key_without_effect_is_named(tmp_path, cli, exact):
    """By the command, from two sensors with noise of their own; nothing slides fast enough here for friction."""
    scatter, strains = np.random.default_rng(1), sensor_reading(simulate(STRIP), "strain", 0.03, TIMES)
    displacement, strain = (
        clean + noise * scatter.standard_normal(TIMES.size) for clean, noise in ((exact, 2e-5), (strains, 1e-6))
    )
    header = "time [ms], displacement@0.2 m [mm], strain@3 cm [um/m]"
    data = written(tmp_path / "d.csv", header, 1e3 * TIMES, 1e3 * displacement, 1e6 * strain)
    slow = GUESS.replace(contact__friction="modified-coulomb", contact__regularization=(10.0, 20.0))
    (tmp_path / "guess.toml").write_text(slow.to_toml())
    vary = [word for key in (*KEYS, "contact.mu_kinetic") for word in ("--vary", key)]
    out = tmp_path / "out"
    code, printed, _ = cli(
        "fit", tmp_path / "guess.toml", data, *vary, "--starts", 2, "--workers", 1, "--out", out
    )
    assert code == 0
    assert "contact.mu_kinetic: has no effect" in printed
    assert "fits as well with another" not in printed
    found = json.loads((out / "results.json").read_text())
    rows = {row["key"]: row for row in found["keys"]}
    for key in KEYS:
        assert rows[key]["low"] < STRIP.value_of(key) < rows[key]["high"]
        # both starts end there
        ends = [start[f"{key} to"] for start in found["starts"]]
        assert ends == pytest.approx([rows[key]["value"]] * 2, rel=1e-2)
    assert [start["sum_of_squares"] for start in found["starts"]] == pytest.approx(
        [found["sum_of_squares"]] * 2, rel=1e-3
    )
    assert rows["contact.mu_kinetic"] == {**rows["contact.mu_kinetic"], "value": 0.3, "low": None, "high": None}
    residuals = pd.read_csv(out / "data.csv")
    # the noise of each sensor is found with the keys, and the residuals are those of the scenario that is written
    fitted = simulate(Scenario.load(str(out / "scenario.toml")))
    for column, noise, place in (("displacement@0.2 m", 2e-5, 0.2), ("strain@3 cm", 1e-6, 0.03)):
        rows_of_it = residuals[residuals["column"] == column]
        assert rows_of_it["deviation"].to_numpy() == pytest.approx(np.full(TIMES.size, noise), rel=0.3)
        again = sensor_reading(fitted, column.partition("@")[0], place, TIMES)
        assert rows_of_it["fitted"].to_numpy() == pytest.approx(again, abs=1e-3 * noise)
    assert "correlation" in (out / "report.html").read_text().lower()


@pytest.mark.parametrize(("deviation", "kind"), [(400e-6, "Jacobian"), (12e-3, "profile")])
def test_the_stiffness_of_a_stop_from_durations_of_contact(tmp_path, deviation, kind):
    """A rigid bar bounces off a soft stop in half a period pi sqrt(J/k)/L.

    What fits four durations is their mean; the interval ends where the duration is that -+ 1.96 sigma/2.
    """
    keys = "beam.youngs_modulus=1e15 discretization.modes=1 contact.normal=spring contact.stiffness=3e3 gravity=0 "
    keys += "contact.friction=frictionless initial.angle=0.01 initial.angular_velocity=-1 slope.angle=0 "
    keys += "slope.origin=[0,0] end_time=0.2 solver.output_interval=1e-2"
    bar = Scenario.builtin("paper", keys.split())
    times = np.array([0.0385, 0.0392, 0.0390, 0.0381])
    header = "collision_duration [ms], collision_duration +- [us]"
    data = written(tmp_path / "t.csv", header, 1e3 * times, [1e6 * deviation] * 4)
    result = fit(bar, data, vary=["contact.stiffness=1 kN/m:20 kN/m"], starts=1, workers=1)
    (row,) = result.frame.itertuples()
    assert row.verdict == kind

    def stiffness(duration):
        return bar.beam.density * bar.beam.area / 3.0 * (math.pi / duration) ** 2

    assert row.value == pytest.approx(stiffness(times.mean()), rel=2e-3)
    for end, moved in ((row.low, 0.98 * deviation), (row.high, -0.98 * deviation)):
        assert math.log(end / row.value) == pytest.approx(
            math.log(stiffness(times.mean() + moved) / stiffness(times.mean())), rel=3e-2
        )
    assert result.about["sum_of_squares"] == pytest.approx(
        np.sum((times - times.mean()) ** 2) / deviation**2, rel=1e-2
    )


def test_keys_that_only_their_product_moves_are_not_identified(tmp_path, exact):
    """Young's modulus and second moment of area: their profiles stay open, and each is named with the other."""
    data = written(tmp_path / "d.csv", "time [s], displacement@0.2 m [m]", TIMES[:8], exact[:8])
    flight = GUESS.adapted(contact__enabled=False)
    result = fit(flight, data, vary=["beam.youngs_modulus", "beam.second_moment"], starts=1, workers=1)
    assert (result.frame["low"] == 0.0).all()
    assert np.isinf(result.frame["high"]).all()
    named = [warning for warning in result.remarks if "not identified" in warning]
    assert [("beam.second_moment" in words, "beam.youngs_modulus" in words) for words in named] == [
        (True, True)
    ] * 2


def test_a_damping_that_is_not_there_gets_an_upper_end(tmp_path, exact):
    noise = 2e-5 * np.random.default_rng(3).standard_normal(TIMES.size)
    data = written(tmp_path / "d.csv", "time [s], displacement@0.2 m [m]", TIMES, exact + noise)
    result = fit(STRIP, data, vary=["contact.damping=1e-4:100"], starts=1, workers=1)
    low, high = result["contact.damping"][["low", "high"]]
    assert (low, result.remarks[1]) == (0.0, "contact.damping: these data set it no lower end")
    # there the sum of squares has grown by t^2
    stiff = STRIP.replace(contact__damping=high)
    off = sensor_reading(simulate(stiff), "displacement", 0.2, TIMES) - exact - noise
    off /= result.tables["data"]["deviation"].to_numpy()
    assert np.sum(off**2) - result.about["sum_of_squares"] == pytest.approx(student.ppf(0.975, 49) ** 2, rel=0.05)


# --- what is refused


def test_a_fit_of_no_key_that_has_an_effect_is_refused(tmp_path, exact):
    """Nothing touches within the first 8 values."""
    data = written(tmp_path / "d.csv", "time [s], displacement@0.2 m [m]", TIMES[:8], exact[:8])
    with refused_in_one_line("contact.stiffness: no effect on these data", start="--vary: "):
        fit(GUESS, data, vary=["contact.stiffness"], starts=1, workers=1)


SERIES = "time [ms], displacement@0.1 m [mm]\n1,2\n2,3\n3,4\n"


@pytest.mark.parametrize(
    ("text", "vary", "words"),
    [
        ("time [ms], strian@0.1 m\n1,2\n", KEYS[1], "column strian@0.1 m: known over time are displacement@PLACE"),
        ("time [ms], velocity@0.1 m\n1,2\n", KEYS[1], "its unit is missing; write velocity@0.1 m [m/s]"),
        (
            "time [ms], velocity@0.1 m [mm]\n1,2\n",
            KEYS[1],
            "column velocity@0.1 m [mm]: should be in m/s, not in mm",
        ),
        ("time [ms], velocity@0.3 m [m/s]\n1,2\n", KEYS[1], "the place should be from 0 to 0.25 m"),
        ("time [ms], theta [deg]\n\n1,two\n", KEYS[1], 'line 3: theta = "two": should be a number, or empty'),
        ("time [ms], theta [deg]\n1,2,3\n", KEYS[1], "line 2: has 3 cells, the header 2"),
        ("time [s], theta [deg]\n1,2\n", KEYS[1], "time: should be from 0 to end_time 0.1 s"),
        ("impuls [N s]\n1\n", KEYS[1], "column impuls: is no quantity of a run; did you mean impulse?"),
        ("time (s), thta (rad)\n1,2\n", KEYS[1], "column thta: known over time are displacement@PLACE"),
        ("time [s], theta []\n0,2\n", KEYS[1], "column theta: its unit is missing; write theta [rad]"),
        ("impulse [-]\n1\n", KEYS[1], "column impulse: its unit is missing; write impulse [N s]"),
        ("time (s), moment (N m)\n0,2\n", KEYS[1], "column moment: known over time are"),
        ("time [ms], theta [deg]\n1,0,2,5\n", KEYS[1], "decimal commas need semicolons between columns"),
        ("time [ms]; theta [deg]\n1,5; 2.5\n", KEYS[1], 'line 2: theta = "2.5": should be a number'),
        ('time [ms], theta [deg]\n1,"2\n2,3\n', KEYS[1], 'line 2: theta = "2\\n2,3\\n": should be a number'),
        ("time [ms], theta [deg]\n1,2\n1," + "1" * 140_000, KEYS[1], "line 3: field larger than field limit"),
        ("impulse +- [N s]\n1\n", KEYS[1], "column impulse +-: there is no column impulse"),
        ("impulse [N s], impulse +- [N s], contacts\n1,1,1\n", KEYS[1], "contacts +-: missing"),
        ("impulse [N s], contacts\n1,1\n", KEYS[1], "column impulse +-: missing; without it at least 3 values"),
        ("impulse [N s], impulse +- [N s]\n1,0\n", KEYS[1], "impulse +-: should be greater than 0"),
        ("", KEYS[1], "should have a line of names with units"),
        (SERIES, "contact.stifness", "did you mean contact.stiffness?"),
        (SERIES, "discretization.modes", "should be a key that is one number"),
        (SERIES, "contact.damping", "--vary contact.damping: is 0 in the scenario"),
        (SERIES, "contact.damping=0:1", "should be KEY=LOW:HIGH, LOW less than HIGH, both above 0"),
        (SERIES, "contact.stiffness=1 m:2 m", "should be in N/m"),
        (SERIES, "gravity=low:1", "should be a number"),
        ("impulse [N s]\n1\n", KEYS[1], "1 values for 1 keys: at least 2 are needed"),
        ("second_impact [s], second_impact +- [s]\n1,1\n", KEYS[1], "no second impact before end_time"),
    ],
)
def test_faulty_files_and_keys_are_refused_in_one_line(tmp_path, refused, text, vary, words):
    (tmp_path / "guess.toml").write_text(GUESS.to_toml())
    (tmp_path / "d.csv").write_text(text)
    line = refused("fit", tmp_path / "guess.toml", tmp_path / "d.csv", "--vary", vary, "--starts", 1)
    assert words in line
    if vary in KEYS:
        assert len(line) < 250 + len(str(tmp_path))


@pytest.mark.parametrize(
    "text",
    [
        "time [ms], displacement@0.2 m [mm], velocity@0.1 m [cm/s]\n2,-0.5,1\n\n# then\n4.5,,18\n5,2,3\n5,2,3\n",
        "time [ms];displacement@0.2 m [mm];velocity@0.1 m [cm/s]\n2;-0,5;1\n4,5;;18\n5;2;3\n5;2;3",
        "time [ms]\tdisplacement@0.2 m [mm]\tvelocity@0.1 m [cm/s]\n2\t-0.5\t1\n4.5\t\t18\n5\t2\t3\n5\t2\t3\n",
        '"time\n(ms)","displacement@20 cm\n(mm)", "velocity@0.1 m (cm/s)"\r\n'
        '"2","-0.5","1"\r\n4.5,"",18\r\n5,2,3\r\n5,2,3\r\n',
    ],
    ids=["commas", "semicolons", "tabs", "quoted breaks"],
)
def test_the_same_numbers_in_other_dialects(tmp_path, text):
    (tmp_path / "d.csv").write_text(text, newline="")
    table = read_measured(tmp_path / "d.csv", STRIP).table
    assert table["time"].tolist() == pytest.approx([0.002, 0.005, 0.005, 0.002, 0.0045, 0.005, 0.005], rel=1e-15)
    assert table["measured"].tolist() == pytest.approx([-0.5e-3, 2e-3, 2e-3, 0.01, 0.18, 0.03, 0.03], rel=1e-15)
    assert table["unit"].tolist() == ["m"] * 3 + ["m/s"] * 4


def test_a_wide_table_column_by_column(tmp_path):
    """Two thousand columns, each with its deviation."""
    header = ", ".join(f"displacement@{n / 1e4} m [mm], displacement@{n / 1e4} m +- [um]" for n in range(1, 1001))
    data = written(
        tmp_path / "d.csv", f"time [ms], {header}", [1.0, 2.0], *([[1.0, n], [n, 2.0]][n % 2] for n in range(2000))
    )
    table = read_measured(data, STRIP).table
    assert table["column"].tolist() == [f"displacement@{n / 1e4} m" for n in range(1, 1001) for _ in range(2)]
    assert table["measured"][::2].to_numpy() == pytest.approx(np.full(1000, 1e-3))
    assert table["measured"][1::2].to_numpy() == pytest.approx(1e-3 * np.arange(0, 2000, 2))
    assert table["deviation"][::2].to_numpy() == pytest.approx(1e-6 * np.arange(1, 2000, 2))


def test_a_table_that_was_exported_is_read(tmp_path):
    """And the run that wrote it says the same of each value, but at jumps, where two samples have one time."""
    history = simulate(STRIP)
    data = export(history, tmp_path / "run.csv").file
    measured = read_measured(data, STRIP)
    columns = set(measured.table["column"])
    assert {"theta", "lambda_n", "energy_elastic", "tip_vy"} <= columns
    assert not {"q_0", "state"} & columns
    values, times = measured.table["measured"].to_numpy(), history["time"].values
    jumps = times[:-1][np.diff(times) < 1e-12]
    smooth = ~measured.table["time"].isin([*jumps, *np.nextafter(jumps, 1.0)])
    assert smooth.sum() > 0.9 * len(values)
    said = measured.predict(history)[smooth]
    assert said == pytest.approx(values[smooth], rel=1e-9, abs=1e-9 * np.abs(values).max())


# --- frequencies and damping ratios, several scenarios, a shift in time

#: a clamped strip on a clamp that yields, without contact
RIG = STRIP.adapted(
    (), contact__enabled=False, root__stiffness=5.0, beam__kelvin_voigt=1e-5, gravity=0.0, initial__angle=0.0
)


def rows_of_modes(path, scenario, frequencies, ratios=0):
    """A table of rows with the first frequencies and damping ratios of a scenario."""
    found = frequencies_at_rest(scenario)
    lines = ["quantity, value, deviation"]
    for k in range(frequencies):
        lines.append(f"frequency:{k + 1} [Hz], {float(found.frequencies[k]) / (2.0 * math.pi)!r}, 0.01")
    lines += [f"damping:{k + 1}, {float(found.damping[k])!r}, 1e-5" for k in range(ratios)]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_frequencies_and_a_damping_ratio_give_clamp_modulus_and_damping_back(tmp_path):
    data = rows_of_modes(tmp_path / "f.csv", RIG, 3, 1)
    guess = RIG.replace(root__stiffness=3.0, beam__youngs_modulus=1.8e11, beam__kelvin_voigt=2e-5)
    keys = ["root.stiffness", "beam.youngs_modulus", "beam.kelvin_voigt"]
    result = fit(guess, data, vary=keys, starts=1, workers=1)
    for key in keys:
        assert result[key].value == pytest.approx(RIG.value_of(key), rel=1e-4)
    assert any(remark.startswith("no two keys stand for each other") for remark in result.remarks)
    assert result.histories == {}


def test_keys_that_stand_for_each_other_are_named(tmp_path):
    """Frequencies know the ratio of modulus and density alone, of the beam on a rigid clamp."""
    rigid = RIG.adapted((), root__stiffness=0.0)
    data = rows_of_modes(tmp_path / "f.csv", rigid, 3)
    keys = ["beam.youngs_modulus", "beam.density"]
    result = fit(rigid.replace(beam__density=7000.0), data, vary=keys, starts=1, workers=1)
    (told,) = (remark for remark in result.remarks if "stand for each other" in remark)
    assert "beam.density and beam.youngs_modulus (1.0000: up together)" in told
    assert abs(result.tables["correlation"].iloc[0, 1]) == pytest.approx(1.0, abs=1e-6)


def test_a_mass_its_place_and_a_clamp_come_from_ranges_with_units(tmp_path):
    heavy = RIG.replace(masses=[{"place": 0.15, "mass": 0.02}], discretization__modes=6)
    data = rows_of_modes(tmp_path / "f.csv", heavy, 4)
    ranges = ["masses.1.mass=5 g:50 g", "masses.1.place=12 cm:200 mm", "root.stiffness=0.002 kN m/rad:20"]
    guess = heavy.replace(masses__1__mass=0.03, masses__1__place=0.16, root__stiffness=3.0)
    result = fit(guess, data, vary=ranges, starts=1, workers=1)
    for key, true in {"masses.1.mass": 0.02, "masses.1.place": 0.15, "root.stiffness": 5.0}.items():
        assert result[key].value == pytest.approx(true, rel=1e-3)


@pytest.mark.parametrize(
    ("start", "vary", "true"),
    [
        ({"deflection": 2e-3}, "initial.deflection=1 mm:5 mm", 2e-3),
        ({"force": 0.3}, "initial.force=0.1:0.001 kN", 0.3),
        ({"deflection": 2e-3}, "forces.1.force=-2:0.002 kN", 0.5),
    ],
)
def test_what_a_plucked_beam_is_held_by_and_a_force_come_from_a_series(tmp_path, start, vary, true):
    initial = {"angle": 0.0, "state": "plucked", "place": 0.2} | start
    plucked = RIG.replace(initial=initial, forces=[{"place": 0.1, "force": 0.5, "frequency": 30.0}], end_time=0.03)
    times = np.linspace(1e-3, 0.03, 20)
    series = sensor_reading(simulate(plucked), "displacement", 0.2, times)
    data = written(tmp_path / "d.csv", "time [ms], displacement@200 mm [mm]", 1e3 * times, 1e3 * series)
    result = fit(plucked, data, vary=[vary], starts=2, workers=1)
    assert result.frame["value"].iloc[0] == pytest.approx(true, rel=1e-4)


def test_two_scenarios_determine_a_key_together_by_the_command(tmp_path, cli):
    """A key is the same in both, and one that acts in one of them alone is found from that."""
    supported = RIG.adapted(
        (), contact__enabled=True, contact__normal="spring", contact__stiffness=2e3, slope__origin=[0.25, 1e-5],
        slope__angle=0.0, initial__state="equilibrium", contact__friction="frictionless",
    )  # fmt: skip
    words = []
    for name, scenario in (("free", RIG), ("held", supported)):
        rows_of_modes(tmp_path / f"{name}.csv", scenario, 2)
        changes = {"root__stiffness": 3.0} | ({"contact__stiffness": 1e3} if name == "held" else {})
        (tmp_path / f"{name}.toml").write_text(scenario.replace(**changes).to_toml())
        words += ["--data", f"{tmp_path / name}.toml={tmp_path / name}.csv"]
    vary = ("--vary", "root.stiffness", "--vary", "contact.stiffness")
    out = tmp_path / "out"
    code, _, error = cli("fit", *words, *vary, "--starts", 1, "--workers", 1, "--out", out)
    assert code == 0, error
    rows = {row["key"]: row["value"] for row in json.loads((out / "results.json").read_text())["keys"]}
    assert rows == pytest.approx({"root.stiffness": 5.0, "contact.stiffness": 2e3}, rel=1e-4)
    assert Scenario.load(str(out / "scenario-2.toml")).contact.stiffness == pytest.approx(2e3, rel=1e-4)
    assert set(pd.read_csv(out / "data.csv")["scenario"]) == {1, 2}


def test_a_series_that_begins_late_gives_its_shift(tmp_path, exact):
    late, noise = 1.5e-3, 2e-5 * np.random.default_rng(5).standard_normal(TIMES.size - 2)
    data = written(
        tmp_path / "d.csv", "time [ms], displacement@200 mm [mm]", 1e3 * (TIMES[1:-1] - late),
        1e3 * (exact[1:-1] + noise),
    )  # fmt: skip
    result = fit(STRIP, data, vary=["contact.stiffness"], shift="-0.001:0.002", starts=1, workers=1)
    assert result["shift"].low < late < result["shift"].high
    assert result["shift"].value == pytest.approx(late, abs=5e-5)


def test_frequencies_stand_beside_a_series(tmp_path, exact):
    """Their lines need no time, and the stiffness of the clamp comes from them alone."""
    yields = STRIP.replace(root__stiffness=200.0)
    hertz = float(frequencies_at_rest(yields).frequencies[0]) / (2.0 * math.pi)
    series = sensor_reading(simulate(yields), "displacement", 0.2, TIMES)
    lines = [f"{1e3 * t!r},{1e3 * w!r},0.02,," for t, w in zip(TIMES.tolist(), series.tolist(), strict=True)]
    header = "time [ms],displacement@200 mm [mm],displacement@200 mm +- [mm],frequency:1 [Hz],frequency:1 +- [Hz]"
    (tmp_path / "d.csv").write_text("\n".join([header, *lines, f"0,,,{hertz!r},0.01"]) + "\n")
    result = fit(
        yields.replace(root__stiffness=150.0), tmp_path / "d.csv", vary=["root.stiffness"], starts=1, workers=1
    )
    assert result["root.stiffness"].value == pytest.approx(200.0, rel=1e-3)
    assert result.tables["data"]["time"].isna().sum() == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("quantity, value\nfrequency:0 [Hz], 3\n", "column frequency:0: should be frequency:N, N from 1 to 100"),
        ("quantity, value\nfrequency:1, 3\n", "column frequency:1: its unit is missing; write frequency:1 [Hz]"),
        ("quantity, value\nfrequency:1 [m], 3\n", "column frequency:1 [m]: should be"),
        ("quantity, value, deviation\nfrequency:1 [Hz], 3\n", "line 2: has 2 cells, the header 3"),
    ],
)
def test_faulty_rows_of_modes_are_refused(tmp_path, text, words):
    (tmp_path / "f.csv").write_text(text)
    with pytest.raises(InputError) as error:
        fit(RIG, tmp_path / "f.csv", vary=["root.stiffness"], starts=1, workers=1)
    assert words in str(error.value)


def test_a_faulty_shift_or_pair_is_refused(tmp_path, exact, cli):
    data = written(tmp_path / "d.csv", "time [ms], displacement@200 mm [mm]", 1e3 * TIMES, 1e3 * exact)
    for shift, words in (
        ("1", "--shift 1: should be LOW:HIGH in s"),
        ("-1:1", "--shift -1:1: should be within what a run holds"),
    ):
        with pytest.raises(InputError) as error:
            fit(STRIP, data, vary=["contact.stiffness"], shift=shift, starts=1, workers=1)
        assert str(error.value).startswith(words)
    for words, told in (
        (("--data", "shaken"), "--data shaken: should be SCENARIO=FILE"),
        (("shaken",), "DATA: missing"),
        ((), "SCENARIO: missing"),
    ):
        code, _, error = cli("fit", *words, "--vary", "contact.stiffness", "--out", tmp_path / "out")
        assert code == 2
        assert told in error
