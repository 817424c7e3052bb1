"""Workers that die: nothing is lost but what was in flight, and nothing is marked falsely."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from itertools import islice

import pandas as pd
import pytest
from verdict_tables import verdicts

from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import PartLimit, Processes, WorkerDiedError, run_units
from steadyload.runs.results import ResultsError, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.worker import RemoteTracebackError, UnpicklableError
from steadyload.studies.report.comparing import compare

BAD = "layout-0002"


def study_of(*methods, generated=6, shard_size=6, **values):
    return StudyDefinition(
        "harm", methods, generated=generated, seed=20, shard_size=shard_size, **values
    )


def judged(folder):
    file = folder / "judged.txt"
    return file.read_text().splitlines() if file.exists() else []


@pytest.mark.usefixtures("outside")
@pytest.mark.parametrize(
    ("harm", "how"),
    [("abort", "by SIGABRT"), ("exit", "with exit status 3"), ("fault", "by SIGSEGV")],
)
def test_an_engine_that_ends_its_process_costs_one_row(tmp_path, harm, how):
    study = study_of(f"harmful:harm={harm}", "fbs")
    assert run_study(study, tmp_path / "run", workers=2) == 12
    frame = load_results(tmp_path / "run")
    (crashed,) = frame[frame["status"] != "done"].itertuples()
    assert (crashed.layout, crashed.status) == (BAD, "crashed")
    assert crashed.reason == f"its process ended {how}, the second in a row"
    assert pd.isna(crashed.score)
    assert pd.isna(crashed.failing_step)
    # Layouts 0 to 2, of which the first is judged twice; twice the bad one; the others.
    assert judged(tmp_path).count(BAD) == 2
    assert len(judged(tmp_path)) == 1 + 3 + 1 + (1 + 3)
    summary = compare(tmp_path / "run").rows.loc[f"harmful:harm={harm}"]
    assert summary["lost"] == {"crashed": 1}
    assert summary["fully_stable"].value == 5 / 6


@pytest.mark.usefixtures("outside")
def test_a_crash_that_does_not_come_again_marks_nothing(tmp_path):
    run_study(study_of("harmful:harm=abort-once"), tmp_path / "run", workers=1)
    assert set(load_results(tmp_path / "run")["status"]) == {"done"}
    assert (tmp_path / "harmless").exists()


@pytest.mark.usefixtures("outside")
def test_a_crash_on_the_first_layout_is_put_down_to_it(tmp_path):
    """It is judged once beforehand."""
    study = study_of("harmful:harm=abort", shard_size=2)
    run_study(study, tmp_path / "run", workers=1)
    frame = load_results(tmp_path / "run").set_index("layout")
    assert (frame["status"] != "done").to_dict() == {n: n == BAD for n in frame.index}


@pytest.mark.usefixtures("outside")
@pytest.mark.parametrize(("work", "first_of_units"), [(0.0, 3), (0.005, 1)])
def test_what_takes_long_is_judged_beforehand_once_a_process(tmp_path, work, first_of_units):
    """Three units: a judgement of microseconds would take longer after another method's."""
    study = study_of(f"harmful:work={work}", generated=6, shard_size=2)
    run_study(study, tmp_path / "run", workers=1)
    assert len(judged(tmp_path)) == 6 + first_of_units
    assert set(load_results(tmp_path / "run")["status"]) == {"done"}


@pytest.mark.usefixtures("outside")
def test_only_what_is_in_flight_is_judged_again(tmp_path):
    """One unit, its worker killed twice: rows that were there stay."""
    cases, kills, deadline = 30, (10, 20), time.monotonic() + 600

    def kill():
        for count in kills:
            while len(judged(tmp_path)) < count and time.monotonic() < deadline:
                time.sleep(0.002)
            (worker,) = multiprocessing.active_children()
            os.kill(worker.pid, signal.SIGKILL)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    study = study_of("harmful:pause=0.02", generated=cases, shard_size=cases)
    run_study(study, tmp_path / "run", workers=1)
    killer.join()
    again = len(kills) + 1  # every worker judges once beforehand
    assert cases + again <= len(judged(tmp_path)) <= cases + again + len(kills)
    assert set(load_results(tmp_path / "run")["status"]) == {"done"}


def test_killed_workers_change_no_table(tmp_path):
    """Real engines. The oldest worker is killed when a unit is finished: it has begun another."""
    study = study_of("ps3@mujoco", "ps3@bullet", "sme", generated=12, shard_size=3)
    killed = set()

    def kill(done, total):
        alive = {worker.pid for worker in multiprocessing.active_children()} - killed
        if 0 < done < total and len(killed) < 3 and alive:
            killed.add(min(alive))
            os.kill(min(alive), signal.SIGKILL)

    assert run_study(study, tmp_path / "killed", workers=2, progress=kill) == 36
    assert len(killed) == 3
    assert not multiprocessing.active_children()
    run_study(study, tmp_path / "calm")
    pd.testing.assert_frame_equal(verdicts(tmp_path / "killed"), verdicts(tmp_path / "calm"))


@pytest.mark.usefixtures("outside")
def test_a_layout_that_is_always_killed_ends_the_study_unmarked(tmp_path):
    """As when memory runs out. All else is finished, and once the cause is gone it goes on."""
    study, run = study_of("harmful:harm=kill", "fbs", shard_size=2), tmp_path / "run"
    with pytest.raises(WorkerDiedError) as caught:
        run_study(study, run, workers=1)
    assert f"harmful:harm=kill on layout {BAD!r} (as given): " in str(caught.value)
    assert "by SIGKILL" in str(caught.value)
    assert judged(tmp_path).count(BAD) == 4
    found = load_results(run)
    assert len(found) == 10
    assert set(found["status"]) == {"done"}
    assert not multiprocessing.active_children()
    (tmp_path / "harmless").touch()
    assert run_study(study, run, workers=1, resume=True) == 2
    run_study(study, tmp_path / "calm")
    pd.testing.assert_frame_equal(verdicts(run), verdicts(tmp_path / "calm"))


@pytest.mark.usefixtures("outside")
def test_a_native_call_that_hangs_costs_one_row_of_status_timeout(tmp_path, monkeypatch):
    """It holds Python's lock, so that nothing in its process can end it."""
    monkeypatch.setattr("steadyload.runs.units.hard_seconds", lambda timeout: 20.0 * timeout)
    study = study_of("harmful:harm=hang", "fbs", timeout=0.1)
    assert run_study(study, tmp_path / "run", workers=1) == 12
    frame = load_results(tmp_path / "run")
    (late,) = frame[frame["status"] != "done"].itertuples()
    assert (late.method, late.layout, late.status) == ("harmful:harm=hang", BAD, "timeout")
    assert late.reason == "no answer within 2 s of CPU time; its process was killed"
    assert pd.isna(late.score)
    assert judged(tmp_path).count(BAD) == 1
    assert not multiprocessing.active_children()


def test_a_hard_limit_is_one_of_every_part(outside):
    unit, quick = outside.Words((0.6, 0.6, 600, 0.6, 600)), outside.Words((0.0,))
    limit = PartLimit(1.0, outside.told_why)
    found = dict(
        run_units(outside.burns, [unit, quick], workers=2, crashed=outside.no_crash, limit=limit)
    )
    why = "no answer within 1 s of CPU time; its process was killed"
    assert found == {unit: [0.6, 0.6, (2, why), 0.6, (4, why)], quick: [0.0]}
    assert not multiprocessing.active_children()


def test_what_waits_is_ended_by_ten_times_as_much_wall_time(outside):
    """Waiting for 0.5 s costs no CPU time: alone it would not end under a limit of 0.25 s."""
    unit = outside.Words((0.5, 600))
    limit = PartLimit(0.25, outside.told_why)
    [(_, found)] = run_units(
        outside.pauses, [unit], workers=1, crashed=outside.no_crash, limit=limit
    )
    assert found == [0.5, (1, "no answer within 2.5 s of wall time; its process was killed")]


@pytest.fixture
def command():
    """Runs a script as a console script is run: its own folder is on the path, not the user's."""

    def run(folder, script, *arguments):
        return subprocess.run(
            [sys.executable, str(script), *arguments], capture_output=True, text=True, cwd=folder,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}, timeout=600,
        )  # fmt: skip

    return run


def test_workers_import_nothing_from_the_working_directory(command, tmp_path):
    (tmp_path / "bin").mkdir()
    script = tmp_path / "bin" / "command.py"
    script.write_text(
        "from steadyload.cli import main\n"
        "if __name__ == '__main__':\n"
        "    raise SystemExit(main())\n"
    )
    folder = tmp_path / "here"
    (folder / "multiprocessing").mkdir(parents=True)
    (folder / "multiprocessing" / "__init__.py").write_text("raise SystemExit('imported')\n")
    (folder / "study.toml").write_text('generated = 2\nmethods = ["fbs"]\n')
    done = command(folder, script, "study", "run", "study.toml", "-o", "run", "-j", "1")
    assert done.returncode == 0, done.stderr
    assert "imported" not in done.stderr
    assert set(load_results(folder / "run")["status"]) == {"done"}


def test_a_method_beside_the_script_is_found_by_workers(command, tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "my_method.py").write_text(
        "from steadyload.methods.rules.base_support import FullBaseSupport\n"
        "from steadyload.methods.contract.method import STABLE\n"
        "class Mine(FullBaseSupport):\n"
        "    def _judge(self, layout, watch):\n"
        "        return STABLE\n"
    )
    (folder / "script.py").write_text(
        "from pathlib import Path\n"
        "from steadyload.methods.registry import METHODS\n"
        "from steadyload.runs.definition import StudyDefinition\n"
        "from steadyload.runs.runner import run_study\n"
        "METHODS['mine'] = 'my_method:Mine'\n"
        "if __name__ == '__main__':\n"
        "    run_study(StudyDefinition('s', ('mine',), generated=2), Path('run'), workers=1)\n"
    )
    done = command(tmp_path, folder / "script.py")
    assert done.returncode == 0, done.stderr
    frame = load_results(tmp_path / "run")
    assert [*frame["method"]] == ["mine", "mine"]
    assert set(frame["status"]) == {"done"}


@pytest.mark.usefixtures("outside")
def test_an_exception_of_the_work_is_raised_here(tmp_path):
    with pytest.raises(ZeroDivisionError, match="nothing was prepared") as caught:
        run_study(study_of("harmful:harm=prepare"), tmp_path / "run", workers=2)
    assert isinstance(caught.value.__cause__, RemoteTracebackError)
    assert "outside_judges.py" in str(caught.value.__cause__)


def test_an_exception_that_cannot_travel_is_told(outside):
    unit = outside.Words(("one",))
    with pytest.raises(RuntimeError, match="_OddError: this and that"):
        list(run_units(outside.odd_failures, [unit], workers=1, crashed=outside.no_crash))


def test_what_cannot_be_sent_is_named(outside):
    unit, held = outside.Words(("HOME",)), outside.Words((threading.Lock(),))
    for work, units, what in (
        (lambda unit: iter(unit.words), [unit], "<lambda>"),
        (outside.variables, [held], "Words"),
        (outside.locks, [unit], "lock"),
    ):
        with pytest.raises(UnpicklableError, match=f"{what}.* cannot be sent between processes"):
            list(run_units(work, units, workers=1, crashed=outside.no_crash))
    assert not multiprocessing.active_children()


def test_workers_keep_to_one_thread(outside, monkeypatch):
    """Libraries read the variable when a worker imports them."""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    unit = outside.Words(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"))
    ((_, answers),) = run_units(outside.variables, [unit], workers=2, crashed=outside.no_crash)
    assert answers == ["1", "3"]
    assert os.getenv("OPENBLAS_NUM_THREADS") is None
    assert os.getenv("OMP_NUM_THREADS") == "3"


def test_fewer_workers_than_none_are_refused(outside):
    with pytest.raises(ValueError, match="workers is -1; allowed: 0"):
        list(run_units(outside.variables, [], workers=-1, crashed=outside.no_crash))


def test_no_more_units_are_asked_for_than_there_is_room_for(outside):
    drawn = []

    def units():
        while True:
            drawn.append(len(drawn))
            yield outside.Words((f"UNSET_{len(drawn)}",))

    answers = run_units(outside.variables, units(), workers=2, crashed=outside.no_crash)
    for done, (_, answer) in enumerate(islice(answers, 20), start=1):
        assert answer == [None]
        assert len(drawn) - done < 4
    answers.close()
    assert not multiprocessing.active_children()


def test_a_part_in_work_is_killed_when_no_more_results_are_wanted(outside):
    units, begin = [outside.Words((0.0,)), outside.Words((600.0,))], time.monotonic()
    answers = run_units(outside.pauses, units, workers=2, crashed=outside.no_crash)
    assert next(answers) == (units[0], [0.0])
    answers.close()
    assert time.monotonic() - begin < 300.0
    assert not multiprocessing.active_children()


def test_an_executor_keeps_its_workers_for_the_same_work(outside):
    def answers(work):
        units = [outside.Words(("PID",)) for _ in range(3)]
        found = run_units(work, units, workers=executor, crashed=outside.no_crash)
        return {answer for _, (answer,) in found}

    with Processes(1) as executor:
        first = answers(outside.processes)
        assert len(first) == 1
        with pytest.raises(RuntimeError, match="_OddError"):
            answers(outside.odd_failures)
        assert answers(outside.variables) == {None}
        again = answers(outside.processes)
        assert again == answers(outside.processes) != first
        with pytest.raises(UnpicklableError):
            answers(lambda unit: iter(unit.words))
        assert answers(outside.processes) != again
    assert not multiprocessing.active_children()


def test_a_script_without_a_guard_is_told_so(command, tmp_path):
    (tmp_path / "script.py").write_text(
        "from pathlib import Path\n"
        "from steadyload.runs.definition import StudyDefinition\n"
        "from steadyload.runs.runner import run_study\n"
        "study = StudyDefinition('s', ('fbs',), generated=2)\n"
        "run_study(study, Path('run'), workers=2)\n"
    )
    done = command(tmp_path, tmp_path / "script.py")
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert "ended with exit status 1 before it could begin" in last
    assert 'if __name__ == "__main__":' in last


def test_workers_that_cannot_begin_are_not_started_forever(outside, tmp_path, monkeypatch):
    monkeypatch.setenv("OUTSIDE_JUDGES_KILL", str(tmp_path / "deaths"))
    with pytest.raises(WorkerDiedError, match="ended by SIGKILL before it could begin"):
        list(
            run_units(
                outside.variables, [outside.Words(("A",))], workers=1, crashed=outside.no_crash
            )
        )
    assert (tmp_path / "deaths").read_text() == 11 * "|"


def test_resuming_needs_a_run(tmp_path):
    with pytest.raises(ResultsError, match="holds no run to resume"):
        run_study(study_of("fbs"), tmp_path / "run", resume=True)
    assert not (tmp_path / "run").exists()


TERMINATED_WHILE_STARTING = """
import multiprocessing.util, os, signal, time
from multiprocessing import resource_tracker
from steadyload.runs.worker import Worker
resource_tracker.ensure_running()
real = multiprocessing.util.spawnv_passfds
def spawning(*arguments):
    started = real(*arguments)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.5)
    return started
multiprocessing.util.spawnv_passfds = spawning
Worker(print)
time.sleep(600)
"""


def test_a_command_that_is_terminated_while_it_starts_a_worker_leaves_no_traceback(command):
    done = command(None, "-c", TERMINATED_WHILE_STARTING)
    assert (done.returncode, done.stderr) == (-signal.SIGTERM, "")
