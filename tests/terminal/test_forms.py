"""Every command in every form that README, first run and how-tos show, as a person sees it in a terminal.

`make test` starts one form of each command, made small, in a terminal of 80 columns, and one command for each
kind of bar in the other terminals; the slow tests start every form, every command in every terminal, and what is
heavy in full.
"""

from __future__ import annotations

import re

import pytest

from oblique_impact import History
from oblique_impact.validation import compare
from tests.terminal import reading
from tests.terminal.forms import Form, demo, forms, prepare, reduced

FORMS = {form.name: form for form in forms()}
#: commands that end at once
NO_BAR = ("schema", "init", "scenarios", "compare")
#: one form of each command with a bar; a run and a call that counts have all there is to bars
EACH = {form.command: form for form in reversed(FORMS.values()) if form.command not in NO_BAR}
KINDS = [pytest.param(EACH[name], marks=[] if name in ("run", "export") else pytest.mark.slow) for name in EACH]
#: the first form of each command, of `render` for each kind of file
FIRST = {
    (form.command, re.sub(r".*(?=\.\w+$)", "", form.words[-1]) if form.command == "render" else ""): name
    for name, form in reversed(FORMS.items())
}
SMALL = [
    pytest.param(name, marks=[] if name in FIRST.values() else pytest.mark.slow)
    for name, form in FORMS.items()
    if not {"--study", "--scheduler"} & set(form.words)
]


def bar_of(form: Form, narrow: bool = False) -> str:
    """The bar that a command shows."""
    if form.command in NO_BAR:
        return reading.RESULTS[form.command]  # too quick for a bar
    if form.command == "run":
        return reading.NARROW_RUN if narrow else reading.RUN
    still = form.command == "render" and re.search(r"\.(png|pdf|svg|html)$", " ".join(form.words))
    if form.command == "modes" or still:
        return r"^(frequencies|picture) +\d:\d\d:\d\d$" if narrow else reading.BUSY
    return reading.NARROW_COUNT if narrow else reading.COUNT


@pytest.fixture
def start_form(start, short_run, tmp_path):
    """Start a form, made small."""

    def call(form: Form, **options):
        prepare(form, tmp_path, short_run)
        few = "tests.terminal.forms:few_cases" if form.command == "reproduce" else ""
        return start(reduced(form), prepare=few, **options)

    return call


def check(command, form: Form, columns: int) -> None:
    terminal = command.finish()
    stopped = "discretization.modes=6" in form.words  # by physics, as the page says
    reading.check_ended_well(command, reading.RESULTS[form.command], 1 if stopped else 0)
    if not stopped:  # the reason is a line of any length
        reading.check_words_are_whole(terminal, columns)
    reading.check_bars_stay_in_one_line(terminal)
    assert reading.saw(terminal, bar_of(form, columns < 60)), sorted(reading.all_lines(terminal))


@pytest.mark.parametrize("name", SMALL)
def test_every_form_in_80_columns(start_form, name):
    check(start_form(FORMS[name]), FORMS[name], 80)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, form in FORMS.items() if "--scheduler" in form.words])
def test_a_cluster_that_is_not_there_is_one_line(start_form, name):
    command = start_form(FORMS[name])
    terminal = command.finish()
    assert command.code == 2
    assert terminal.text.replace("\n", "").startswith("oblique-impact: --scheduler 127.0.0.1:9: cannot be reached")
    assert not any(block in terminal.text for block in reading.BLOCKS)


@pytest.mark.parametrize("columns", [120, 40])
@pytest.mark.parametrize("form", KINDS, ids=EACH)
def test_wide_and_narrow(start_form, form, columns):
    check(start_form(form, columns=columns), form, columns)


@pytest.mark.parametrize("form", KINDS, ids=EACH)
def test_a_dumb_terminal_gets_plain_text(start_form, form):
    command = start_form(form, environment={"TERM": "dumb"})
    terminal = command.finish()
    reading.check_ended_well(command, reading.RESULTS[form.command])
    assert not re.search(rb"[^\n\r -~]", terminal.raw), terminal.raw


@pytest.mark.parametrize("form", KINDS, ids=EACH)
def test_no_colours_are_no_reason_for_no_bar(start_form, form):
    command = start_form(form, environment={"NO_COLOR": "1"})
    check(command, form, 80)
    assert not re.search(rb"\x1b\[[\d;]*m", re.sub(rb"\x1b\[[0-4]?m", b"", command.terminal.raw))


@pytest.mark.parametrize("form", KINDS, ids=EACH)
def test_results_go_into_a_pipe_and_the_bar_to_the_terminal(start_form, form, tmp_path):
    out = tmp_path / "piped"
    out.touch()
    command = start_form(form, stdout=out)
    terminal = command.finish()
    assert command.code == 0, terminal.text
    assert reading.saw(terminal, bar_of(form)), sorted(reading.all_lines(terminal))
    piped = out.read_bytes()
    assert not re.search(rb"[^\n -~]", piped), piped
    # the warm process has compiled what the run needs: there is nothing to tell of that
    allowed = () if form.command == "run" else ("oblique-impact: ",)
    assert all(line.startswith(allowed) for line in terminal.lines), terminal.text
    assert re.search(reading.RESULTS[form.command], piped.decode() + terminal.text)


def test_the_demo(start, tmp_path):
    command = start([*demo(), "4"])
    terminal = command.finish()
    assert command.code == 0, terminal.text
    assert "Traceback" not in terminal.text
    assert "…" not in terminal.text, "something was cut off"
    assert not any(block in terminal.text for block in reading.BLOCKS)
    reading.check_words_are_whole(terminal, 80)
    reading.check_bars_stay_in_one_line(terminal)
    for bar in (reading.RUN, reading.BUSY, r"^film [━╸╺]+ \d/4 "):
        assert reading.saw(terminal, bar), sorted(reading.all_lines(terminal))
    assert b"m4/4\x1b" in terminal.raw  # written for certain, even if it is taken away before a tenth of a second
    assert (terminal.cursor_hidden, terminal.column) == (False, 0)
    assert "largest difference of an event time" in terminal.text
    target = tmp_path / demo()[1]
    for name, least in (
        ("overview.png", 50_000),
        ("paper.mp4", 20_000),
        ("strip.png", 20_000),
        ("paper.html", 100_000),
    ):
        assert (target / name).stat().st_size > least
        assert re.search(rf"^ *\w+: {demo()[1]}/{name}$", terminal.text, re.MULTILINE)
    assert "events: 21 shared" in (target / "compared.md").read_text()
    modal, fem = (History.load(target / name) for name in ("modal", "fem"))
    assert compare(modal, fem, ["gap"]).largest_shift < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, form in FORMS.items() if "--scheduler" not in form.words])
def test_every_form_as_it_stands(start, short_run, tmp_path, name):
    """In full, with its own processes; what a page's reader would have to install is made small."""
    form = FORMS[name]
    prepare(form, tmp_path, short_run)
    words = reduced(form) if "mine" in form.words else list(form.words)
    if form.command == "render" and form.words[-1].endswith(".mp4"):
        words += ["--frames", "20"]
    check(start(words, real=True), form, 80)
