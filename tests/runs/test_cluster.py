"""A study on a Dask cluster: a real scheduler, real workers, and the rows of this process."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing, suppress
from itertools import count, islice

import dask
import pandas as pd
import psutil
import pytest
from distributed import Client, Security
from distributed.comm import connect
from verdict_tables import verdicts

from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packing.packing import random_layouts
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import (
    ExecutorError,
    WorkerDiedError,
    make_executor,
    run_units,
)
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.units import OtherCodeError
from steadyload.runs.with_dask import Dask

_BAD = "layout-0002"


class Cluster:
    """A scheduler, and workers that come and go."""

    def __init__(self, folder):
        self._folder, self._file, self.processes = folder, folder / "scheduler.json", []

    def begin(self):
        """Start the scheduler; its address is known when its file is whole."""
        self._start("scheduler", "--port", "0")
        deadline = time.monotonic() + 600
        while time.monotonic() < deadline:
            with suppress(FileNotFoundError, json.JSONDecodeError):
                self.address = json.loads(self._file.read_text())["address"]
                return
            time.sleep(0.05)
        raise TimeoutError("no scheduler within ten minutes")

    def add(self, *arguments, path=()):
        """Start a worker with one thread."""
        where = ["--local-directory", str(self._folder), "--nthreads", "1"]
        return self._start("worker", *where, *arguments, path=path)

    def _start(self, *arguments, path=()):
        command = [sys.executable, "-m", "dask", *arguments, "--scheduler-file", str(self._file)]
        process = subprocess.Popen(
            [*command, "--host", "127.0.0.1", "--no-dashboard"],
            cwd=self._folder,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join([*path, *filter(None, sys.path)])},
        )  # fmt: skip
        self.processes.append(process)
        return process

    def kill(self, process):
        """End it, a nanny, what it watches, and processes of seats, at once."""
        self.processes.remove(process)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def close(self):
        """End it all."""
        for process in [*self.processes]:
            self.kill(process)


@pytest.fixture
def cluster(tmp_path):
    """A cluster without workers."""
    with closing(Cluster(tmp_path)) as made:
        made.begin()
        yield made


def study_of(methods, generated, shard_size):
    return StudyDefinition(
        "far", tuple(methods.split()), generated=generated, seed=20, shard_size=shard_size
    )


def test_a_killed_worker_changes_no_table(cluster, tmp_path):
    """Real engines. When the first unit is done, a worker that is at another is killed for good:
    itself, its nanny, and what judges.
    """
    nannies = {process.pid: process for process in (cluster.add("--nanny"), cluster.add("--nanny"))}
    study, killed = study_of("ps3@mujoco sme", 8, 2), []

    def kill(done, total):
        at_work = [address for address, units in client.processing().items() if units]
        if 0 < done < total and not killed:
            killed.append(nannies[parents[at_work[0]]])
            cluster.kill(killed[0])

    with Client(cluster.address) as client, Dask(scheduler=cluster.address) as executor:
        client.wait_for_workers(2, timeout=600)
        parents = client.run(os.getppid)
        assert run_study(study, tmp_path / "run", workers=executor, progress=kill) == 16
        assert len(client.nthreads()) == 1
    assert killed
    run_study(study, tmp_path / "calm")
    pd.testing.assert_frame_equal(verdicts(tmp_path / "run"), verdicts(tmp_path / "calm"))


@pytest.mark.usefixtures("outside")
def test_an_engine_that_ends_its_process_costs_the_row_that_it_costs_here(cluster, tmp_path):
    cluster.add("--no-nanny")
    study = study_of("harmful:harm=abort fbs", 6, 6)
    with Dask(scheduler=cluster.address) as executor:
        assert run_study(study, tmp_path / "far", workers=executor) == 12
    run_study(study, tmp_path / "near", workers=1)
    found = verdicts(tmp_path / "far")
    assert found.set_index("layout")["status"].eq("crashed").groupby("layout").sum()[_BAD] == 1
    pd.testing.assert_frame_equal(found, verdicts(tmp_path / "near"))


@pytest.mark.usefixtures("outside")
def test_other_code_on_a_worker_is_refused(cluster, tmp_path):
    """The method's file has one line more there."""
    site, other = tmp_path / "site", tmp_path / "other"
    other.mkdir()
    changed = (site / "outside_judges.py").read_text() + "# changed\n"
    (other / "outside_judges.py").write_text(changed)
    cluster.add("--no-nanny", path=[str(other), str(site)])
    study = study_of("harmful", 2, 2)
    with Dask(scheduler=cluster.address) as executor:
        with pytest.raises(
            OtherCodeError, match=r"would judge by source of Harmful .* instead of"
        ) as caught:
            run_study(study, tmp_path / "run", workers=executor)
        assert "(on the Dask worker tcp://127.0.0.1:" in caught.value.__notes__[0]
    assert not list((tmp_path / "run" / "results").glob("*.parquet"))


def test_a_worker_without_this_package_is_told_so(cluster, tmp_path):
    (tmp_path / "empty" / "steadyload").mkdir(parents=True)
    missing = "raise ModuleNotFoundError('steadyload')\n"  # a development install lends submodules
    (tmp_path / "empty" / "steadyload" / "__init__.py").write_text(missing)
    cluster.add("--no-nanny", path=[str(tmp_path / "empty")])
    with Client(cluster.address) as client:
        client.wait_for_workers(1, timeout=600)
        with pytest.raises(ExecutorError, match="cannot import what is to run there"):
            Dask(scheduler=cluster.address)


def test_no_more_units_are_handed_over_than_there_is_room_for(outside, cluster):
    cluster.add("--no-nanny")
    drawn = []

    def units():
        for number in count():
            drawn.append(number)
            yield outside.Words((f"UNSET_{number}",))

    with Dask(scheduler=cluster.address) as executor:
        answers = run_units(outside.variables, units(), workers=executor, crashed=outside.no_crash)
        for done, (_, answer) in enumerate(islice(answers, 8), start=1):
            assert answer == [None]
            assert len(drawn) - done < executor.room
        answers.close()


def test_only_the_certificate_of_a_local_cluster_opens_its_ports(outside):
    """Another user of the machine reaches all of them."""
    me, stranger = psutil.Process(), Security.temporary()
    before = {c.laddr.port for c in _listening(me)}
    with Dask(workers=1) as executor:
        unit = outside.Words(("HOME",))
        ((_, answers),) = run_units(
            outside.variables, [unit], workers=executor, crashed=outside.no_crash
        )
        assert answers == [os.environ["HOME"]]
        found = [c for p in (me, *me.children(recursive=True)) for c in _listening(p)]
        ports = {c.laddr.port for c in found} - before
        assert {c.laddr.ip for c in found} == {"127.0.0.1"}
        assert not any(_opens("tcp", port, Security()) for port in ports)
        assert not any(_opens("tls", port, stranger) for port in ports)
        own = executor._client.security
        # The scheduler, the nanny, and the worker; others speak HTTP. One that is busy is asked
        # once more.
        opened = set()
        for _ in range(20):
            opened |= {port for port in ports - opened if _opens("tls", port, own)}
            if len(opened) >= 3:
                break
        assert len(opened) == 3


def _opens(scheme, port, security):
    """Whether something at a port talks Dask's protocol with whoever has these certificates."""

    async def ask():
        arguments = security.get_connection_args("client")
        (await connect(f"{scheme}://127.0.0.1:{port}", timeout=0.5, **arguments)).abort()

    try:
        asyncio.run(asyncio.wait_for(ask(), 2.0))
    except OSError:
        return False
    return True


def _listening(process):
    return [c for c in process.net_connections("tcp") if c.status == psutil.CONN_LISTEN]


def test_a_scheduler_that_does_not_answer_is_named():
    with pytest.raises(ExecutorError, match=r"'tcp://127\.0\.0\.1:9': Timed out .* allowed: the"):
        Dask(scheduler="tcp://127.0.0.1:9", patience=0.3)
    with pytest.raises(ExecutorError, match="unknown address scheme 'http'"):
        Dask(scheduler="http://127.0.0.1:8786")
    with pytest.raises(ExecutorError, match="workers is 2; allowed: none beside a scheduler"):
        Dask(scheduler="tcp://127.0.0.1:9", workers=2)


@pytest.mark.usefixtures("outside")
def test_a_unit_whose_dask_workers_die_is_left_out_unmarked(tmp_path, monkeypatch):
    """As when the memory of their machines runs out. Once the cause is gone it goes on."""
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    study = study_of("harmful:harm=kill-parent", 4, 2)
    with closing(Cluster(tmp_path)) as cluster:
        cluster.begin()
        cluster.add("--nanny")
        with Dask(scheduler=cluster.address) as executor:
            with pytest.raises(WorkerDiedError) as caught:
                run_study(study, tmp_path / "run", workers=executor)
            assert "harmful:harm=kill-parent on layout" in str(caught.value)
            assert "its Dask worker was lost, time and again" in str(caught.value)
            (tmp_path / "harmless").touch()
            assert run_study(study, tmp_path / "run", workers=executor, resume=True) >= 2
    run_study(study, tmp_path / "calm")
    pd.testing.assert_frame_equal(verdicts(tmp_path / "run"), verdicts(tmp_path / "calm"))


@pytest.mark.usefixtures("outside")
def test_an_exception_of_the_work_is_raised_here(cluster, tmp_path):
    cluster.add("--no-nanny")
    study = study_of("harmful:harm=prepare", 2, 2)
    with (
        Dask(scheduler=cluster.address) as executor,
        pytest.raises(ZeroDivisionError, match="nothing was prepared") as caught,
    ):
        run_study(study, tmp_path / "run", workers=executor)
    assert "outside_judges.py" in str(caught.value.__cause__)
    assert "on the Dask worker tcp://127.0.0.1:" in caught.value.__notes__[0]


@pytest.mark.usefixtures("outside")
def test_a_scheduler_that_is_lost_ends_the_run(cluster, tmp_path):
    """What is finished stays."""
    cluster.add("--no-nanny")
    study = study_of("harmful:pause=0.05", 40, 2)

    def kill(done, total):
        if done and len(cluster.processes) > 1:
            cluster.kill(cluster.processes[0])

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "5s"}),
        Dask(scheduler=cluster.address) as executor,
        pytest.raises(WorkerDiedError, match="is gone"),
    ):
        run_study(study, tmp_path / "run", workers=executor, progress=kill)
    assert 0 < len(load_results(tmp_path / "run")) < 40


def test_an_interrupted_cluster_of_this_machine_leaves_nothing_and_can_be_resumed(
    begin_study, tmp_path
):
    (tmp_path / "study.toml").write_text(
        'shard_size = 1\nlayouts = ["layouts.json"]\nmethods = ["ps3@mujoco"]\n'
    )
    write_layouts(tmp_path / "layouts.json", random_layouts(40, seed=20), Format.NATIVE)
    with socket.socket() as other:  # another cluster's, of which nobody wants to hear
        with suppress(OSError):
            other.bind(("", 8787))
            other.listen()
        process = begin_study(tmp_path, "--executor", "dask", "-j", "2")
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=1800)
    assert process.returncode == 130, errors
    assert errors.splitlines() == [
        "steadyload: interrupted; what is finished stays in run, and the same command goes on"
    ]


def test_executors_are_told_what_they_have():
    with pytest.raises(ExecutorError, match="did you mean 'dask'"):
        make_executor("dusk")
    with pytest.raises(ExecutorError, match="'processes' has no scheduler; allowed: with dask"):
        make_executor("processes", scheduler="tcp://127.0.0.1:9")
    with pytest.raises(ExecutorError, match="'serial' has no workers; allowed: with processes or"):
        make_executor("serial", workers=2, scheduler=None)


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cryptography", None)
    with pytest.raises(ExecutorError, match=r"cryptography: pip install 'steadyload\[dask\]'"):
        make_executor("dask", workers=1)
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "steadyload.runs.with_dask")
    with pytest.raises(ExecutorError, match=r"pip install 'steadyload\[dask\]'"):
        make_executor("dask")
