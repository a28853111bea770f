"""Many items on processes: in order, one that dies costs itself alone, what is compiled is told here."""

from __future__ import annotations

import math
import os
import signal
from concurrent.futures import Future
from contextlib import nullcontext
from importlib import import_module

import pytest

from oblique_impact import InputError
from oblique_impact.kernels.compiling import announce, compilations
from oblique_impact.validation.parallel import Crash, check_limits, compute_each, map_parallel


@pytest.mark.parametrize("workers", [1, 2])
def test_results_keep_the_order_of_the_items(workers):
    seen = []
    items = [9.0, 4.0, 1.0]
    results = map_parallel(math.sqrt, items, workers, lambda index, result: seen.append((index, result)))
    assert results == [3.0, 2.0, 1.0]
    assert sorted(seen) == [(0, 3.0), (1, 2.0), (2, 1.0)]


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_in_a_process_is_raised_here(workers):
    with pytest.raises(ValueError, match=r"negative|domain"):
        map_parallel(math.sqrt, [1.0, -1.0], workers)


def deadly(item):
    """Count a start of each item in its file; some end their process, always or the first time."""
    file, what = item
    with file.open("a") as target:
        target.write("x")
    if what == "always" or (what == "once" and file.read_text() == "x"):
        os.kill(os.getpid(), signal.SIGKILL)
    return what


def test_an_item_that_takes_its_process_down_twice_costs_itself_alone(tmp_path):
    whats = ["", "once", "", "always", "", "", "", "", "", ""]
    items = [(tmp_path / str(number), what) for number, what in enumerate(whats)]
    found = dict(compute_each(deadly, items, 2))
    assert found.pop(3) == Crash("its process ended, twice: killed by SIGKILL")
    assert found == {number: what for number, what in enumerate(whats) if number != 3}
    assert (tmp_path / "3").read_text().startswith("xx")
    with pytest.raises(InputError, match=r"always.*killed by SIGKILL"):
        map_parallel(deadly, [(tmp_path / "a", "always"), (tmp_path / "b", "")], 2)


def whereabouts(_):
    announce("a kernel")
    return os.getpid(), os.environ["OMP_NUM_THREADS"]


def test_processes_are_others_with_one_thread_each_and_tell_what_they_compile():
    told = []
    with compilations(told.append):
        ((_, (pid, threads)),) = compute_each(whereabouts, [None], 2, isolated=True)
    assert pid != os.getpid()
    assert threads == "1"
    assert told == ["a kernel"]


@pytest.mark.parametrize("address", ["", "nonsense", "nonsense:::", "tcp://", "host", "ftp://host:1", "tcp://h:x"])
def test_bad_addresses_are_one_line(address):
    with pytest.raises(InputError, match="tcp://host:8786"):
        check_limits(address, None, None)


@pytest.mark.parametrize("address", ["tcp://10.0.0.1:8786", "localhost:8786", "tls://[::1]:8786"])
def test_good_addresses_pass(address):
    check_limits(address, None, 0.1)


@pytest.mark.parametrize("timeout", [0.0, -1.0, math.nan])
def test_a_timeout_is_a_time(timeout):
    with pytest.raises(InputError, match="--timeout"):
        check_limits(None, None, timeout)


class Scheduler:
    """Stands for a connection to a cluster whose workers die of negative numbers."""

    status = "running"

    def get_executor(self, **_):
        return self

    def submit(self, function, item):
        found = Future()
        try:
            found.set_result(function(item))
        except ValueError:
            found.set_exception(pytest.importorskip("distributed").KilledWorker("task", None, 3))
        except ImportError as error:
            found.set_exception(error)
        return found

    def shutdown(self, wait=True):
        self.status = "closed"


@pytest.fixture
def cluster(monkeypatch):
    scheduler = Scheduler()
    monkeypatch.setattr("oblique_impact.validation.parallel._client", lambda address: nullcontext(scheduler))
    return scheduler


def test_an_item_that_takes_its_workers_down_costs_itself_alone(cluster):
    found = dict(compute_each(math.sqrt, [4.0, -1.0, 9.0], scheduler="tcp://h:1"))
    assert found == {0: 2.0, 1: Crash("its workers died, again and again"), 2: 3.0}
    assert cluster.status == "closed"


def test_a_lost_cluster_is_one_line(cluster):
    cluster.status = "connecting"
    with pytest.raises(InputError, match=r"tcp://h:1: the connection is lost"):
        list(compute_each(math.sqrt, [4.0, 9.0], scheduler="tcp://h:1"))


def test_workers_that_cannot_run_are_one_line(cluster):
    with pytest.raises(InputError, match=r"a worker cannot run: ModuleNotFoundError"):
        list(compute_each(import_module, ["no.such.module"], scheduler="tcp://h:1"))
