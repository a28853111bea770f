"""Every command in every form that README, first run and how-tos show, as a person sees it in a terminal."""

from __future__ import annotations

import re

import pytest

from tests.terminal import reading
from tests.terminal.forms import Form, demo, forms, prepare, reduced

FORMS = forms()
#: one form of each command
EACH = list({form.command: form for form in reversed(FORMS)}.values())
DUMB = {"TERM": "dumb"}


def bar_of(form: Form, narrow: bool = False) -> str:
    """The bar that a command shows."""
    if form.command == "run":
        return reading.NARROW_RUN if narrow else reading.RUN
    film = form.command == "render" and not re.search(r"\.(png|html)$", " ".join(form.words))
    if form.command == "modes" or (form.command == "render" and not film):
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


def is_refused(form: Form) -> bool:
    return "--scheduler" in form.words


@pytest.mark.parametrize("form", [f for f in FORMS if not is_refused(f)], ids=lambda form: form.name)
def test_every_form_in_80_columns(start_form, form):
    command = start_form(form)
    terminal = command.finish()
    reading.check_ended_well(command, reading.RESULTS[form.command])
    reading.check_words_are_whole(terminal, 80)
    reading.check_bars_stay_in_one_line(terminal)
    assert reading.saw(terminal, bar_of(form)), sorted(reading.all_lines(terminal))


@pytest.mark.parametrize("form", list(filter(is_refused, FORMS)), ids=lambda form: form.name)
def test_a_cluster_that_is_not_there_is_one_line(start_form, form):
    command = start_form(form)
    terminal = command.finish()
    assert command.code == 2
    assert terminal.text.startswith("oblique-impact: --scheduler")
    assert "\n" not in terminal.raw.decode().strip()


@pytest.mark.parametrize("columns", [120, 40])
@pytest.mark.parametrize("form", EACH, ids=lambda form: form.command)
def test_wide_and_narrow(start_form, form, columns):
    command = start_form(form, columns=columns)
    terminal = command.finish()
    reading.check_ended_well(command, reading.RESULTS[form.command])
    reading.check_words_are_whole(terminal, columns)
    reading.check_bars_stay_in_one_line(terminal)
    assert reading.saw(terminal, bar_of(form, narrow=columns < 60)), sorted(reading.all_lines(terminal))


@pytest.mark.parametrize("form", EACH, ids=lambda form: form.command)
def test_a_dumb_terminal_gets_plain_text(start_form, form):
    command = start_form(form, environment=DUMB)
    terminal = command.finish()
    reading.check_ended_well(command, reading.RESULTS[form.command])
    assert not re.search(rb"[^\n\r\t -~\x80-\xff]", terminal.raw), terminal.raw


@pytest.mark.parametrize("form", EACH, ids=lambda form: form.command)
def test_results_go_into_a_pipe_and_the_bar_to_the_terminal(start_form, form, tmp_path):
    out = tmp_path / "piped"
    out.touch()
    command = start_form(form, stdout=out)
    terminal = command.finish()
    assert command.code == 0, terminal.text
    assert reading.saw(terminal, bar_of(form)), sorted(reading.all_lines(terminal))
    piped = out.read_bytes()
    assert not re.search(rb"[\x00-\x09\x0b-\x1f\x7f]", piped), piped
    notes = [line for line in terminal.lines if not line.startswith("oblique-impact: ")]
    assert notes == []
    assert re.search(reading.RESULTS[form.command], piped.decode() + terminal.text)


def test_the_demo(start):
    words = [*demo(), "4"]
    command = start(words)
    terminal = command.finish()
    assert command.code == 0, terminal.text
    assert "Traceback" not in terminal.text
    assert "…" not in terminal.text, "something was cut off"
    assert not any(block in terminal.text for block in reading.BLOCKS)
    reading.check_words_are_whole(terminal, 80)
    reading.check_bars_stay_in_one_line(terminal)
    for bar in (reading.RUN, reading.BUSY, r"^film ━+ 4/4 "):
        assert reading.saw(terminal, bar), sorted(reading.all_lines(terminal))
    assert "  page: out/demo/paper.html" in terminal.lines
    assert terminal.text.count("impact -> slip") >= 6
    assert (terminal.cursor_hidden, terminal.column) == (False, 0)
