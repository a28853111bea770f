"""Shared by all tests: the last few runs of built-in scenarios, and a browser."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys

import pytest
from playwright.sync_api import Page, sync_playwright

from oblique_impact.machine import collect_rarely

# before anything imports NumPy: for the small matrices here more threads than one only wait for each other, which
# took up to ten times the time where several test processes share the cores
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# a shell lets what it starts in the background ignore interrupts; the tests of interrupts send them
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

collect_rarely()

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")


def pytest_unconfigure() -> None:
    """What the system takes back at once is not given back object by object."""
    gc.freeze()


@pytest.fixture(scope="session")
def run():
    """Simulate a built-in scenario (default: the paper's) with overrides; the last few are remembered."""
    from oblique_impact.validation.runs import run as simulated

    return lambda name="paper", *overrides: simulated(name, *overrides)


@pytest.fixture
def interpreted(monkeypatch):
    """Run kernels interpreted: for a short run whose combination of model and scheme no other test compiles."""
    import numba

    monkeypatch.setattr(numba.config, "DISABLE_JIT", True)


@pytest.fixture
def cli(capfd, monkeypatch):
    """Call the command line in this process: (exit code, standard output, standard error)."""
    from oblique_impact.command_line.application import main

    def call(*arguments: object) -> tuple[int, str, str]:
        words = [str(argument) for argument in arguments]
        monkeypatch.setattr(sys, "argv", ["oblique-impact", *words])
        with pytest.raises(SystemExit) as stopped:
            main(words)
        captured = capfd.readouterr()
        return int(stopped.value.code or 0), captured.out, captured.err

    return call


@pytest.fixture
def refused(cli):
    """Call the command line with what it refuses in one line, before anything is written; returns the line."""

    def call(*arguments: object) -> str:
        code, out, err = cli(*arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), (out, err)
        return err

    return call


@pytest.fixture(scope="session")
def display():
    """An X server without a screen, by the name of its display."""
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("there is no X server (Debian: xvfb)")
    reader, writer = os.pipe()
    words = [server, "-displayfd", str(writer), "-screen", "0", "1400x900x24", "-nolisten", "tcp"]
    process = subprocess.Popen(words, pass_fds=[writer], stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        number = pipe.readline().strip()
    yield f":{number}"
    process.terminate()
    process.wait()


@pytest.fixture(scope="session")
def browser():
    """The Chromium of this machine, without a window."""
    binary = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if binary is None:
        pytest.skip(f"none of {', '.join(CHROMIUM)} is on the PATH")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=binary, args=["--no-sandbox"])
        yield chromium
        chromium.close()


def watched(browser) -> tuple[Page, list[str]]:
    """A new page of the browser, and a list of the faults that it reports and of what it asks for but files."""
    page, faults = browser.new_page(viewport={"width": 1280, "height": 720}), []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda entry: faults.append(entry.text) if entry.type in ("error", "warning") else None)
    page.on("request", lambda request: request.url.startswith("file:") or faults.append(request.url))
    return page, faults


@pytest.fixture
def page(browser):
    """A page of the browser that may report no fault and ask for nothing but files."""
    page, faults = watched(browser)
    yield page
    page.close()
    assert faults == []
