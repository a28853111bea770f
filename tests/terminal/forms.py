"""Every command in every form that the documentation shows, and how each is made small enough for the tests."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path
from typing import NamedTuple

from oblique_impact import simulate
from oblique_impact.progress import OnProgress
from oblique_impact.renders.outputs import FILMS
from tests.docs.test_docs_commands import DOCS, PAGES, ROOT, files_of, inline, lines_of, parse

OURS = "oblique-impact"
#: long enough for a bar to be seen, with few samples
SEEN = ("--set", "end_time=4", "--set", "solver.output_interval=1e-2")
SWEEP = """
scenario = "paper"
quantities = ["energy_lost"]
changes = {end_time = 0.02}
axes = [{key = "contact.restitution", values = [0.0, 0.1, 0.2, 0.3]}]
"""


class Form(NamedTuple):
    """A command of a page."""

    page: Path
    words: tuple[str, ...]

    @property
    def name(self) -> str:
        return f"{self.page.stem}: {' '.join(self.words[1:])}"

    @property
    def command(self) -> str:
        return self.words[1]


def _options_of_a_table(page: Path) -> list[list[str]]:
    """Commands of the table in which a page shows options of `render`."""
    cells = re.findall(r"^\| [^|]+ \| `(--[^`]+)`", page.read_text(encoding="utf-8"), re.MULTILINE)
    words = [shlex.split(cell) for cell in cells]
    return [[OURS, "render", "out/paper", *w, *(() if "--out" in w else ("--out", "film.mp4"))] for w in words]


def forms() -> list[Form]:
    """Those of README, first run, how-tos and the pages beside them, each once."""
    found: dict[tuple[str, ...], Form] = {}
    for page in PAGES:
        tables = _options_of_a_table(page) if page == DOCS / "howto" / "film.md" else []
        for words in [*lines_of(page), *inline(page), *tables]:
            if words[0] == OURS and len(words) > 2:
                found.setdefault(tuple(words), Form(page, tuple(words)))
    return list(found.values())


def demo() -> list[str]:
    """What `make demo` starts."""
    recipe = re.search(r"^demo:.*\n\t(.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert recipe
    program, script, *arguments = recipe[1].split()
    assert program.endswith("/python")
    return [str(ROOT / script), *arguments]


def prepare(form: Form, folder: Path, run: Path) -> None:
    """Put into `folder` what the command reads: the page's files, and `run` for every history."""
    for name, text in files_of(form.page).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "small.toml").write_text(SWEEP, encoding="utf-8")
    understood = parse(list(form.words))
    if form.command == "init":
        (folder / understood["file"]).unlink()
    names = [understood.get(name) for name in ("history", "left", "right")]
    for source in [*names, *(understood.get("histories") or [])]:
        if source is not None and not (folder / source).exists():
            shutil.copytree(run, folder / source)


def reduced(form: Form) -> list[str]:
    """Words of the same command over a shorter time, of fewer frames, levels or checks."""
    words, understood = list(form.words), parse(list(form.words))
    if form.command == "run":
        words += SEEN
    elif form.command == "refine":
        words += ["--set", "end_time=0.02", "--set", "solver.output_interval=1e-3", "--workers", "1"]
        words = [re.sub(r"@[\d.]+", "@0.01", word).replace("impulse", "energy_final") for word in words]
    elif form.command == "sweep":
        words[2] = "small.toml"
        words = ["127.0.0.1:9" if "//" in word else word for word in words]
        words += [] if understood.get("scheduler") else ["--workers", "1"]
    elif form.command == "validate":
        at = words.index("--only") if "--only" in words else len(words)
        words[at : at + 2] = [
            "--only",
            "small-systems.belt",
            "--only",
            "small-systems.thrown-up",
            "--workers",
            "1",
        ]
    elif form.command == "reproduce":
        words += ["--workers", "1"]
    elif form.command == "export" and not {"--every", "--all"} & set(words):
        words += ["--every", "10"]
    elif form.command == "render" and Path(understood["out"]).suffix in (".png", *FILMS):
        words += ["--size", "320x180"]
        words += ["--frames", "3"] if Path(understood["out"]).suffix in FILMS else []
    return words


def few_cases() -> None:
    """Leave of `reproduce` the command around it and two short runs: nothing is judged, drawn or written."""
    from types import SimpleNamespace

    from oblique_impact.validation.parallel import map_parallel, told
    from oblique_impact.validation.reproduction import command

    def brief(out: Path, workers: int | None, on_progress: OnProgress, typed: str) -> SimpleNamespace:
        scenarios = [case.scenario.replace(end_time=1.0) for case in command.main_cases()[:2]]
        map_parallel(simulate, scenarios, workers, told(on_progress, ["one", "two"]))
        return SimpleNamespace(
            verdicts={"reproduced": 0},
            claims=(),
            material=SimpleNamespace(undiscriminating=0),
            report=out / "report.html",
        )

    command.reproduce = brief
