"""A judgement is ended by its CPU time; by wall time alone only after ten times as much."""

import multiprocessing
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from steadyload import time_limit
from steadyload.core.timed import Followed
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import make_method
from steadyload.methods.contract import stopwatch
from steadyload.methods.contract.method import Status
from steadyload.methods.contract.stopwatch import Stopwatch
from steadyload.methods.equilibrium import equilibrium
from steadyload.runs.pool import run_units
from steadyload.time_limit import BACKSTOP, TimeoutExpiredError, cpu_clock, seconds_of_process


@pytest.fixture
def judged(stack, told_time):
    """Judges a column under a limit, in units of the CPU time that it takes."""

    def judge(limit, busy):
        method, layout = make_method("ps3@mujoco"), stack(0.0, 0.0)
        with pytest.MonkeyPatch.context() as patch:
            told_time("mujoco", stopwatch, time_limit, busy=busy, patch=patch)
            return method.judge(layout, timeout=limit * method.judge(layout).cpu.total)

    return judge


@pytest.mark.parametrize("busy", [1.0, 9.0])
def test_a_busy_machine_changes_no_verdict(judged, busy):
    assert judged(1.1, busy).status is Status.DONE
    late = judged(0.9, busy)
    assert (late.status, late.score) == (Status.TIMEOUT, None)
    assert late.reason.endswith("s of CPU time")


def test_wall_time_is_a_backstop(judged):
    assert judged(1.1, 1.0 * BACKSTOP).status is Status.DONE
    late = judged(1.1, 1.2 * BACKSTOP)
    assert late.status is Status.TIMEOUT
    assert late.reason.endswith("s of wall time")


def test_threads_do_not_charge_one_another(monkeypatch):
    """Where no wall time passes, as only CPU time is looked at here."""
    clock = SimpleNamespace(
        process_time=time.process_time, thread_time=time.thread_time, perf_counter=lambda: 0.0
    )
    monkeypatch.setattr(time_limit, "time", clock)
    watch = Stopwatch(timeout=0.1)

    def compute():
        end = time.thread_time() + 0.3
        while time.thread_time() < end:
            pass

    beside = threading.Thread(target=compute)
    beside.start()
    beside.join()
    watch.check()
    compute()
    with pytest.raises(TimeoutExpiredError, match=r"no verdict within 0\.1 s of CPU time"):
        watch.check()


def test_a_worker_counts_what_its_engine_computes_in_threads_of_its_own(outside):
    unit = outside.Words(("where",))
    [(_, [there])] = run_units(outside.cpu_clocks, [unit], workers=1, crashed=None)
    assert there == ["process_time", "thread_time"]
    [here] = outside.cpu_clocks(unit)
    assert here == ["thread_time", "thread_time"]


def test_the_clock_of_another_process_is_its_cpu_time():
    before = time.process_time()
    found = seconds_of_process(threading.main_thread().native_id)
    assert before <= found <= time.process_time()
    assert seconds_of_process(2**22 - 1) == 0.0


def test_steps_that_take_long_are_those_of_much_cpu_time(monkeypatch):
    """Wall time that passes while a machine does something else makes no step a long one."""
    boxes = tuple(Item(k, (0.0, 10.0 * k, 0.0), (10.0, 10.0, 10.0), 1.0) for k in range(40))
    tower = Layout("tower", Pallet(100.0, 500.0, 100.0), boxes)
    method, real = make_method("equilibrium:time=0.3"), Followed.first
    batches, now = [], SimpleNamespace(cpu=0.0, wall=0.0)

    def judging(cpu):
        def placing(loading, first, end, how):
            batches.append(end - first)
            now.cpu, now.wall = now.cpu + cpu, now.wall + 10.0
            return real(loading, first, end, how)

        return placing

    clock = SimpleNamespace(thread_time=lambda: now.cpu, perf_counter=lambda: now.wall)
    monkeypatch.setattr(equilibrium, "time", clock)
    for cpu, expected in ((0.001, [32, 4, 4]), (1.0, [32, *[1] * 8])):
        batches.clear()
        monkeypatch.setattr(Followed, "first", judging(cpu))
        assert method.judge(tower).stable
        assert batches == expected


def _clock_of_a_worker(_):
    with ThreadPoolExecutor(1) as threads:
        return cpu_clock() is time.process_time, threads.submit(cpu_clock).result() is (
            time.thread_time
        )


def test_the_time_of_the_process_counts_in_the_main_thread_of_a_worker_alone():
    assert cpu_clock() is time.thread_time
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as workers:
        assert [*workers.map(_clock_of_a_worker, [0])] == [(True, True)]
