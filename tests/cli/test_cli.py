"""The command as a user runs it: in this process, and in a fresh one where that says more."""

import json
import subprocess
import sys
from types import SimpleNamespace

import pytest

from steadyload.cli import main
from steadyload.layouts.formats import Format, read_layouts, write_layouts

ITEM = {"sequence": 0, "position": [0, 0, 0], "size": [10, 10, 10], "weight": 1}
SECOND = {"sequence": 1, "position": [20, 0, 0], "size": [10, 10, 10], "weight": 1}


@pytest.fixture
def steadyload(monkeypatch, capfd):
    """Runs the command in this process; what engines print by themselves is seen, too."""

    def run(*arguments, cwd):
        monkeypatch.chdir(cwd)
        capfd.readouterr()
        status = main([str(word) for word in arguments])
        told = capfd.readouterr()
        return SimpleNamespace(returncode=status, stdout=told.out, stderr=told.err)

    return run


def in_a_fresh_process(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "steadyload.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=600,  # a hang; the first run may compile for a minute or two
    )


def native(*items):
    layout = {"name": "A", "pallet": {"width": 50, "height": 50, "depth": 50}, "items": items}
    return json.dumps({"format": "steadyload-layouts", "version": 1, "layouts": [layout]})


@pytest.fixture
def layout_file(tmp_path, stack):
    layouts = [stack(0.0, 3.0, 0.0).renamed("stands"), stack(0.0, 7.0).renamed("falls")]
    write_layouts(tmp_path / "layouts.json", layouts, Format.NATIVE)
    return tmp_path / "layouts.json"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (native(ITEM | {"weight": float("nan")}), "weight is nan kg"),
        (native(ITEM | {"weight": -2}), "weight is -2 kg"),
        (native(ITEM | {"size": [10, 0, 10]}), "height is 0 cm"),
        (native(ITEM, SECOND | {"position": [5, 0, 0]}), "overlaps item 0"),
        (native(ITEM | {"position": [55, 0, 0]}), "inside the pallet's contour"),
        (native(ITEM, SECOND | {"sequence": 0}), "sequence 0 stands there twice"),
        (native(ITEM)[:-30], "is it cut off?"),
        ("<xml/>", "is in no known format"),
        ("", "is empty"),
    ],
    ids=[
        "nan", "negative", "zero", "overlapping", "out-of-contour", "duplicate-sequence",
        "truncated", "wrong-format", "empty",
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence_and_status_2(steadyload, tmp_path, content, message):
    (tmp_path / "bad.json").write_text(content)
    done = steadyload("score", "bad.json", "--json", "-m", "ps3@mujoco", "-m", "sme", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert "bad.json" in done.stderr
    assert done.stderr.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["bad.json"]


def test_a_large_garbage_file_is_refused(steadyload, tmp_path):
    (tmp_path / "garbage").write_bytes(bytes(range(256)) * (20 * 1024 * 4))
    done = steadyload("score", "garbage", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


@pytest.mark.parametrize(
    "arguments",
    [
        ("score", "missing.json"),
        ("score", "."),
        ("score", "layouts.json", "-m", "smee"),
        ("score", "layouts.json", "-m", "ps3@jolt"),
        ("score", "layouts.json", "--max-items", "0"),
        ("score", "layouts.json", "--scenario", "S3"),
        ("convert", "layouts.json", "-o", "no/such/folder/x.csv"),
        ("convert", "layouts.json", "-o", "x.yaml", "--to", "aclpp"),
        ("study", "report", "."),
        ("study", "run", "missing.toml"),
        ("study", "run", "embedded", "--resume", "-o", "nothing"),
        ("study", "run", "embedded", "--resume", "--rerun"),
        ("study", "run", "embedded", "--executor", "serial", "-j", "2"),
        ("study", "run", "embedded", "--scheduler", "tcp://127.0.0.1:9"),
        ("study", "run", "embedded", "--executor", "dask", "--scheduler", "nowhere"),
        ("study", "run", "embedded", "--executor", "dusk"),
        ("methods", "nothing"),
        ("pages", "remake", "tabel5"),
        ("scroe", "layouts.json"),
        ("verify", "closed-form"),
        ("convert", "layouts.json"),
        ("score",),
    ],
)
def test_wrong_arguments_end_with_status_2_and_no_traceback(steadyload, layout_file, arguments):
    done = steadyload(*arguments, cwd=layout_file.parent)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.engine("bullet")
def test_scores_as_json(steadyload, layout_file):
    done = steadyload(
        "score", layout_file, "-m", "sme", "-m", "ps3@bullet", "--json", cwd=layout_file.parent
    )
    assert (done.returncode, done.stderr) == (0, "")
    records = json.loads(done.stdout)
    assert [(r["layout"], r["method"]) for r in records] == [
        ("stands", "sme"), ("stands", "ps3@bullet"), ("falls", "sme"), ("falls", "ps3@bullet"),
    ]  # fmt: skip
    for record in records:
        keys = {"layout", "method", "items", "score", "failing_step", "status", "wall_seconds"}
        assert keys <= set(record)
        assert record["status"] == "done"
        assert record["wall_seconds"] > 0
        falls = record["layout"] == "falls"
        assert (record["failing_step"], record["score"]) == ((1, 0.5) if falls else (None, 1.0))


def test_the_deck_is_an_option_of_commands_that_read_layouts(steadyload, tmp_path, stack):
    write_layouts(tmp_path / "over.json", [stack(-46.0, -46.0)], Format.NATIVE)

    def scored(*arguments):
        done = steadyload("score", "over.json", "--json", *arguments, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        [record] = json.loads(done.stdout)
        return record["floor"], record["score"]

    assert scored() == ("deck", 0.0)
    assert scored("--floor", "infinite") == ("infinite", 1.0)
    assert scored("--overhang", "6", "--floor", "auto") == ("deck", 0.0)
    for arguments, message in (
        (("--overhang", "5"), "contour, -5 to 105 cm (+-0.01): up to 5 cm over the edge"),
        (("--overhang", "-1"), "--overhang: '-1'; allowed: a number, 0 or more"),
        (("--floor", "desk"), "--floor: 'desk'; did you mean 'deck'?"),
    ):
        for command in (("score", "over.json"), ("view", "over.json"),
                        ("convert", "over.json", "-o", "made.json")):  # fmt: skip
            done = steadyload(*command, *arguments, cwd=tmp_path)
            assert (done.returncode, done.stdout) == (2, "")
            assert message in done.stderr
    done = steadyload(
        "convert", "over.json", "-o", "plane.json", "--floor", "infinite", cwd=tmp_path
    )
    assert done.returncode == 0
    assert '"floor": "infinite"' in (tmp_path / "plane.json").read_text()
    done = steadyload("study", "run", "embedded", "--floor", "deck", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "labels hold for an infinite floor" in done.stderr


def test_scores_for_people(steadyload, layout_file):
    done = steadyload("score", layout_file, "-m", "sme", cwd=layout_file.parent)
    header, first, second = done.stdout.splitlines()
    assert header.split()[:3] == ["layout", "method", "boxes"]
    assert first.split()[:4] == ["stands", "sme", "3", "1.000"]
    assert second.split()[:5] == ["falls", "sme", "2", "0.500", "2"]


def test_a_reader_that_goes_away_is_no_error(layout_file):
    done = subprocess.run(
        f"{sys.executable} -m steadyload.cli score {layout_file} --json | head -1",
        shell=True,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""


def test_converting_there_and_back(steadyload, layout_file, tmp_path):
    for arguments in (("-o", "a.csv"), ("-o", "b.json", "--to", "job")):
        assert steadyload("convert", layout_file, *arguments, cwd=tmp_path).returncode == 0
    original = read_layouts(layout_file)
    for name in ("a.csv", "b.json"):
        assert [lay.items for lay in read_layouts(tmp_path / name)] == [
            lay.items for lay in original
        ]


@pytest.mark.engine("bullet")
def test_a_study_from_definition_to_report(steadyload, layout_file, tmp_path):
    (tmp_path / "s.toml").write_text(
        'layouts = ["layouts.json"]\nmethods = ["fbs", "simulation@bullet:frequency=60"]\n'
    )
    done = steadyload("study", "run", "s.toml", "-j", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    report = steadyload("study", "report", "runs/s", cwd=tmp_path)
    assert report.stdout.strip() == "runs/s/report.md"
    assert (tmp_path / "runs" / "s" / "report.md").read_text().startswith("# Study: s")


def test_a_timeout_is_a_record(steadyload, layout_file):
    done = steadyload(
        *("score", layout_file, "-m", "ps3-literal@dart", "--timeout", "1e-6", "--json"),
        cwd=layout_file.parent,
    )
    assert done.returncode == 0
    for record in json.loads(done.stdout):
        assert (record["status"], record["score"]) == ("timeout", None)


def test_engines_leave_no_files_behind_and_keep_quiet(layout_file):
    before = sorted(p.name for p in layout_file.parent.iterdir())
    done = in_a_fresh_process(
        *("score", layout_file, "-m", "ps3@bullet", "-m", "ps3@mujoco", "-m", "ps3@dart", "--json"),
        cwd=layout_file.parent,
    )
    assert done.stderr == ""
    json.loads(done.stdout)
    assert sorted(p.name for p in layout_file.parent.iterdir()) == before


def test_real_schedules_score_twice_the_same(steadyload, aclpp_files, tmp_path):
    command = (
        *("score", *aclpp_files[:2], "-m", "sme", "-m", "ps_opt-paper@mujoco", "--json"),
        *("--max-items", 12, "--scenario", "S1", "--limit", 20),
    )
    runs = [json.loads(steadyload(*command, cwd=tmp_path).stdout) for _ in range(2)]
    scores = [[(r["layout"], r["method"], r["score"]) for r in run] for run in runs]
    assert len(scores[0]) == 40
    assert scores[0] == scores[1]
    assert all(r["status"] == "done" for r in runs[0])
