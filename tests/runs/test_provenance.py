"""What makes stored rows stale, and what does not."""

import platform
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from steadyload.methods.cascade import cascade
from steadyload.methods.contract import method
from steadyload.methods.registry import METHODS, make_method, method_class
from steadyload.methods.simulation.simulation import Simulation
from steadyload.runs.definition import load_study
from steadyload.runs.provenance import key_of, made_by, provenance, provenance_lines, source_line
from steadyload.runs.runner import run_study

ROOT = Path(__file__).parents[2]
CPUINFO = Path("/proc/cpuinfo")

STUDY = """
generated = 2
methods = ["sme", "equilibrium", "ps3@mujoco", "lstm_1:outside=accept"]
"""

MOVED = {
    "methods/rules/sme.py": "methods/ramos.py",
    "statics/balance.py": "methods/vertical.py",
    "methods/simulation/loading.py": "methods/algorithm.py",
    "engines/with_mujoco.py": "engines/mujoco_world.py",
    "layouts/model/contacts.py": "layouts/touching_faces.py",
    "learners/methods.py": "learners/networks_that_judge.py",
}


def copy_with_moved_modules(folder):
    """The package as it might be next year: modules have other names, and every text is another."""
    heavy = shutil.ignore_patterns("__pycache__", "data", "data_planar", "published")
    shutil.copytree(ROOT / "harness", folder, ignore=heavy)
    for name in ("engines", "learners", "reports"):
        shutil.copytree(ROOT / name, folder / name, ignore=heavy)
    for old, new in MOVED.items():
        (folder / old).rename(folder / new)
    for path in folder.rglob("*.py"):
        text = path.read_text()
        for old, new in MOVED.items():
            was, becomes = (name.removesuffix(".py").replace("/", ".") for name in (old, new))
            text = text.replace(f"steadyload.{was}", f"steadyload.{becomes}")
        path.write_text(f"{text}\n# Said in other words.\n")


def test_modules_that_are_moved_and_reworded_leave_every_row_fresh(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    run = tmp_path / "run"
    assert run_study(load_study(tmp_path / "study.toml"), run) == 8
    copy_with_moved_modules(tmp_path / "site" / "steadyload")
    script = """
import sys
from pathlib import Path
from steadyload.methods.registry import make_method
from steadyload.runs.definition import load_study
from steadyload.runs.runner import run_study
computed = run_study(load_study(Path("study.toml")), Path("run"))
print(computed, type(make_method("sme")).__module__, sys.modules["steadyload"].__file__)
"""
    # Nothing is judged there, and so nothing is compiled for the new folder.
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True,
        env={"PYTHONPATH": str(tmp_path / "site"), "NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    computed, module, file = done.stdout.split()
    assert (computed, module) == ("0", "steadyload.methods.ramos")
    assert file.startswith(str(tmp_path))


def test_what_is_raised_is_computed_again(tmp_path, monkeypatch):
    (tmp_path / "study.toml").write_text(STUDY)
    study, run = load_study(tmp_path / "study.toml"), tmp_path / "run"
    run_study(study, run)
    monkeypatch.setattr(Simulation, "version", Simulation.version + 1)
    assert run_study(study, run) == 2
    for parts in ({"loading": 2}, {"scene": 2}, {"world": 2}):
        monkeypatch.setattr(Simulation, "built_on", {**Simulation.built_on, **parts})
        assert run_study(study, run) == 2
        assert run_study(study, run) == 0


@pytest.mark.parametrize(
    "spec", ["fbs", "sme", "equilibrium", "ps3@mujoco", "label@reference", "lstm_e"]
)
def test_a_method_says_what_it_is_made_by(spec):
    made = made_by(make_method(spec))
    assert made == made_by(make_method(spec))
    assert made["version of method"] == "1"
    assert {name for name in made if name in ("numpy", "scipy", "numba", "mujoco")} == {
        "fbs": {"numpy"}, "sme": {"numpy"}, "equilibrium": {"numpy", "scipy"},
        "ps3@mujoco": {"numpy", "mujoco"}, "label@reference": {"numpy", "scipy", "numba"},
        "lstm_e": {"numpy"},
    }[spec]  # fmt: skip
    assert ("version of core" in made) == ("@" not in spec)


def test_a_cascade_is_made_by_its_stages(monkeypatch):
    made = made_by(make_method("cascade@mujoco"))
    assert made["version of engine of ps_opt@mujoco"] == "1"
    assert {"numpy", "scipy", "mujoco", "weights and thresholds"} <= set(made)
    assert "version of core of equilibrium:time=0.3" in made
    assert "pybullet" not in made
    assert cascade.Cascade.version == 1


def test_a_tuned_preset_keeps_its_spec_and_is_another_method(monkeypatch):
    one = make_method("ps_opt@mujoco")
    again = type(one)(one.spec, type(one.parameters)(**{**vars(one.parameters), "eps_t": 9.25}))
    assert str(one) == str(again)
    assert made_by(one) != made_by(again)


def test_every_method_declares_parts_and_packages():
    for name in METHODS:
        made = make_method(name + ("@mujoco" if method_class(name).needs_engine else ""))
        assert set(made.parts()) >= {"method"}
        assert all(isinstance(number, int) for number in made.parts().values())
        assert all(metadata.version(package) for package in made.numerics())


class Elsewhere(method.Method):
    """A class of no version: its source stands for it."""

    def _judge(self, layout, watch):
        return method.STABLE


def test_the_source_of_a_class_from_elsewhere_counts(monkeypatch):
    made = made_by(Elsewhere(make_method("fbs").spec, make_method("fbs").parameters))
    assert len(made["source of Elsewhere"]) == 64
    entry = metadata.EntryPoint("elsewhere", f"{__name__}:Elsewhere", "steadyload.methods")
    entry = entry._for(metadata.distribution("numpy"))
    monkeypatch.setattr(
        "steadyload.runs.provenance.metadata.entry_points",
        lambda group: [entry] if group == "steadyload.methods" else [],
    )
    told = made_by(Elsewhere(make_method("fbs").spec, make_method("fbs").parameters))
    assert told["numpy"] == metadata.version("numpy")


def test_a_key_hangs_on_content_alone():
    assert key_of({"a": 1, "b": [2.5, None]}) == key_of({"b": [2.5, None], "a": 1})
    assert key_of({"a": 1}) != key_of({"a": 2})
    assert len(key_of([])) == 20
    with pytest.raises(ValueError, match="Out of range"):
        key_of({"a": float("nan")})


def test_a_provenance_reads_as_lines():
    made = provenance() | {"git": "0123456789ab"}
    assert provenance_lines(made)["source"] == "git 0123456789ab"
    version = metadata.version("steadyload")
    assert source_line(made | {"git": None}) == f"installed package {version}"
    of_rows = {f"rows: {name}": text for name, text in provenance_lines(made).items()}
    assert provenance_lines(made, of="rows") == of_rows


def test_a_page_names_the_processor_that_its_times_are_of():
    told = CPUINFO.read_text().splitlines() if CPUINFO.exists() else []
    models = [line.partition(":")[2].strip() for line in told if line.startswith("model name")]
    machine = provenance_lines()["machine"]
    assert machine.startswith(f"{platform.system()} {platform.machine()}, ")
    assert not models or models[0] in machine
    assert platform.node() not in machine


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A clone with a module and a published page, which the code seems to run from."""
    module = tmp_path / "harness" / "runs" / "provenance.py"
    page = tmp_path / "reports" / "published" / "report.md"
    for file in (module, page, tmp_path / "harness" / "methods" / "envelopes.json"):
        file.parent.mkdir(parents=True)
        file.write_text("1\n")
    who = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], [*who, "commit", "-qm", "first"]):
        subprocess.run(["git", "-C", str(tmp_path), *words], check=True)
    monkeypatch.setattr("steadyload.runs.provenance.__file__", str(module))
    return module, page


def test_a_page_that_was_remade_leaves_the_revision_clean(tree):
    module, page = tree
    clean = provenance()["git"]
    assert len(clean) == 12
    page.write_text("2\n")
    assert provenance()["git"] == clean
    (module.parents[1] / "methods" / "envelopes.json").write_text("2\n")
    assert provenance()["git"] == clean
    module.write_text("2\n")
    assert provenance()["git"] == f"{clean}-dirty"


def test_outside_a_clone_there_is_no_revision(tree):
    module, _ = tree
    shutil.rmtree(module.parents[2] / ".git")
    assert provenance()["git"] is None


def test_a_tree_of_which_git_cannot_say_whether_it_has_changes_is_not_called_clean(tree):
    module, _ = tree
    (module.parents[2] / ".git" / "index").write_bytes(b"damaged")
    assert provenance()["git"] is None
