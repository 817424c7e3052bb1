"""``steadyload tune`` as a user runs it, on a small labelled set."""

import json
import os
import shutil
import signal
import time

import pandas as pd
import pytest
from pyarrow import parquet

from steadyload.atomic import manifest_text
from steadyload.cli import main
from steadyload.layouts.benchmark.dataset import KEYS, load_benchmark
from steadyload.layouts.benchmark.parts import SHIPPED
from steadyload.tuning.ledger import Ledger

CASES = 2
pytestmark = pytest.mark.usefixtures("file_in_this_process")


@pytest.fixture(scope="module")
def small_set(tmp_path_factory):
    """Of the shipped labelled set, the first cases of every scenario of validation."""
    folder = tmp_path_factory.mktemp("set")
    found = load_benchmark().select("validation", limit=CASES)
    for name, keys in (("layouts", ["layout"]), ("cases", KEYS), ("opinions", KEYS)):
        table = parquet.read_table(SHIPPED / f"{name}.parquet")
        wanted = pd.MultiIndex.from_frame(found[keys])
        kept = pd.MultiIndex.from_frame(table.select(keys).to_pandas()).isin(wanted)
        parquet.write_table(table.filter(kept), folder / f"{name}.parquet")
    manifest = json.loads((SHIPPED / "manifest.json").read_text())
    for of_the_whole in ("checksums", "checksum", "stands"):
        manifest.pop(of_the_whole, None)
    (folder / "manifest.json").write_text(manifest_text(manifest))
    return folder


@pytest.fixture(scope="module")
def command(small_set):
    return [
        "tune", "--engine", "mujoco", "--benchmark", str(small_set), "--population", "4", "-j", "1",
        "--cost", str(small_set / "cost.json"),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def tuned_folder(command, tmp_path_factory, file_in_this_process):
    """Of a search over one generation."""
    folder = tmp_path_factory.mktemp("tune") / "run"
    assert main([*command, "--generations", "1", "-o", str(folder)]) == 0
    return folder


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--engine", "mojuco", "--budget", "1s"), "unknown engine 'mojuco'"),
        (("--engine", "reference", "--budget", "1s"), "there is nothing to tune"),
        (("--engine", "mujoco"), "a search needs a number of generations or a budget"),
        (("--engine", "mujoco", "--budget", "1s", "--algorithm", "x"), "unknown algorithm 'x'"),
        (("--engine", "mujoco", "--budget", "1s", "--space", "table4"), "unknown space 'table4'"),
        (("--engine", "mujoco", "--budget", "1s", "--benchmark", "no"), "no"),
        (("--remake", "ps_opt@nothing"), "ps_opt@nothing: no search found it"),
    ],
)
def test_what_cannot_be_searched_is_a_sentence(tmp_path, monkeypatch, capfd, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["tune", *arguments]) == 2
    output, errors = capfd.readouterr()
    assert message in errors
    assert errors.startswith("steadyload: ")
    assert errors.count("\n") == 1
    assert not output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--engine", "mujoco", "--budget", "soon"), "allowed: a time such as 90s, 20m or 1.5h"),
        (("--engine", "mujoco", "--budget", "0m"), "allowed: a time such as 90s, 20m or 1.5h"),
        (("--engine", "mujoco", "--budget", "-3"), "--budget"),
        (("--engine", "mujoco", "--population", "3"), "a whole number, 4 or more"),
        (("--engine", "mujoco", "--remake", "ps_opt@mujoco"), "not allowed with"),
        (("--budget", "20m"), "one of the arguments --engine --remake is required"),
    ],
)
def test_wrong_arguments_end_with_status_2(tmp_path, monkeypatch, capfd, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["tune", *arguments]) == 2
    assert message in capfd.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_search_writes_its_page_and_is_done_once(command, tuned_folder, small_set, capfd):
    ledger = tuned_folder / "search.jsonl"
    before = ledger.read_bytes()
    assert main([*command, "--generations", "1", "-o", str(tuned_folder)]) == 0
    output, errors = capfd.readouterr()
    [page] = output.splitlines()
    assert page == str(tuned_folder / "report.md")
    text = "".join(each.read_text() for each in tuned_folder.glob("report*.md"))
    [history] = (tuned_folder / "figures").glob("searches.*.svg")
    assert f"](figures/{history.name})" in text
    assert history.stat().st_size > 5000
    assert "ps_opt@mujoco would be simulation@mujoco:" in errors
    assert ledger.read_bytes() == before, "nothing is judged again"
    _, found = Ledger.of(tuned_folder)
    assert len(found.ends) == 1
    assert all(len(e.trial) == 3 * CASES for e in found.entries.values())
    kept = json.loads((small_set / "cost.json").read_text())
    assert kept["about"]["engine"] == "mujoco"
    assert kept["model"] == found.facts["model"]


def test_what_judging_costs_is_measured_once(
    command, tuned_folder, small_set, tmp_path, capfd, undrawn
):
    again = [*command, "--generations", "1", "--seed", "5", "-o", str(tmp_path / "run")]
    assert main(again) == 0
    assert "measuring" not in capfd.readouterr().err
    models = [Ledger.of(run)[1].facts["model"] for run in (tuned_folder, tmp_path / "run")]
    assert models[0] == models[1]
    text = (small_set / "cost.json").read_text()
    for content, message in (
        (text.replace('"mujoco"', '"bullet"'), "is of engine 'bullet', space 'extended'; name"),
        (text.replace('"extended"', '"table3"'), "is of engine 'mujoco', space 'table3'; name"),
        (text[:40], "holds no cost model; name another file"),
    ):
        (tmp_path / "cost.json").write_text(content)
        arguments = ["--cost", str(tmp_path / "cost.json"), "-o", str(tmp_path / "other")]
        assert main([*command, "--generations", "1", *arguments]) == 2
        assert message in capfd.readouterr().err


def test_another_search_in_the_folder_is_refused(command, tuned_folder, capfd):
    before = (tuned_folder / "search.jsonl").read_bytes()
    again = [*command, "--generations", "1", "--seed", "5", "-o", str(tuned_folder)]
    assert main(again) == 2
    assert "holds another search (seed differ)" in capfd.readouterr().err
    assert (tuned_folder / "search.jsonl").read_bytes() == before


def test_a_preset_of_changed_code_is_refused_before_the_search(command, tuned_folder, tmp_path,
                                                               capfd):  # fmt: skip
    run = shutil.copytree(tuned_folder, tmp_path / "run")
    lines = [json.loads(line) for line in (run / "search.jsonl").read_text().splitlines()]
    for line in lines:
        if line.get("fact") == "made_by":
            line["value"]["git"] = "0123456789ab-dirty"
            del line["sum"]
    (run / "search.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert main([*command, "--generations", "9", "-o", str(run), "--write-preset"]) == 2
    assert "in no commit" in capfd.readouterr().err
    assert len(Ledger.of(run)[1].ends) == 1


def test_an_interrupt_ends_a_search_in_one_line(begin, command, tuned_folder, tmp_path):
    """Ctrl-C reaches the whole process group, whoever proposes among it."""
    run = shutil.copytree(tuned_folder, tmp_path / "run")
    process = begin(*command, "--budget", "1h", "-o", str(run))
    while process.poll() is None and len(Ledger.of(run)[1].ends) < 3:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130, errors
    assert [line for line in errors.splitlines() if not line.startswith("generation ")] == [
        f"steadyload: interrupted; what is finished stays in {run}, and the same command goes on"
    ]
    assert len(Ledger.of(run)[1].ends) >= 3
