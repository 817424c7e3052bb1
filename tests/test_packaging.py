"""One name at top level: what the wheel holds, and what stands beside a user's script."""

import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
import setuptools
import yaml
from packaging.requirements import Requirement

import steadyload
from steadyload.core import building

ROOT = Path(__file__).parents[1]
FOLDERS = {"harness": "", "engines": "engines/", "learners": "learners/", "reports": "reports/"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation",
               "--disable-pip-version-check", "--wheel-dir", str(folder), str(ROOT)]  # fmt: skip
    subprocess.run(command, check=True)
    return next(folder.glob("*.whl"))


def installed_path(tracked):
    """Where a tracked file of the repository is installed; None for one that is not."""
    top, _, rest = tracked.partition("/")
    if top not in FOLDERS or tracked.startswith(("reports/published/", "reports/rows/")):
        return None
    return f"steadyload/{FOLDERS[top]}{rest}"


def test_the_wheel_holds_the_tracked_files_under_one_name(wheel, project):
    listed = subprocess.run(
        ["git", "-C", str(ROOT), "ls-files"], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    tracked = {installed_path(file) for file in listed if (ROOT / file).exists()} - {None}
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    about = {name for name in names if name.split("/")[0].endswith(".dist-info")}
    library = f"steadyload/core/lib/{building.name()}"
    assert names - about == {*tracked, library}
    assert wheel.name.endswith(f"-py3-none-{sysconfig.get_platform().replace('-', '_')}.whl")
    assert {name.split("/")[0] for name in about} == {
        f"steadyload-{project['project']['version']}.dist-info"
    }


def test_files_beside_a_script_change_nothing(wheel, tmp_path):
    site, script = tmp_path / "site", tmp_path / "script"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    (script / "reports").mkdir(parents=True)
    for other in ("engines.py", "harness.py", "learners.py", "reports/__init__.py"):
        (script / other).write_text("raise SystemExit('a file of the user was imported')\n")
    main = script / "main.py"
    main.write_text(
        "import sys\n"
        f"sys.path.insert(1, {str(site)!r})\n"
        "import steadyload as sl\n"
        "from steadyload.methods.registry import method_listing\n"
        f"assert sl.__file__.startswith({str(site)!r}), sl.__file__\n"
        "print(sl.make_method('sme'), sl.make_method('ps3@mujoco'), len(method_listing()) > 10)\n"
    )
    done = subprocess.run([sys.executable, str(main)], capture_output=True, text=True, cwd=script)
    assert (done.returncode, done.stdout) == (0, "sme ps3@mujoco True\n"), done.stderr


PLAN = """\
layout,pallet_width,pallet_height,pallet_depth,sequence,x,y,z,width,height,depth,weight
A18,120,160,80,0,0,0,0,40,30,40,12
A18,120,160,80,1,25,30,0,40,30,40,9
"""


def test_the_wheel_answers_in_an_empty_environment_and_compiles_once(wheel, tmp_path):
    """The package and its command are the wheel's alone, installed by pip; what it depends on is
    not installed anew, which would take a network, but found where this process finds it.
    """
    environment, elsewhere = tmp_path / "environment", tmp_path / "elsewhere"
    venv.create(environment)
    python = environment / "bin" / "python"
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps",
         "--no-index", "--disable-pip-version-check", str(wheel)], check=True,
    )  # fmt: skip
    [site] = environment.glob("lib/python*/site-packages")
    others = [path for path in sys.path if Path(path).name == "site-packages"]
    (site / "others.pth").write_text("\n".join(others) + "\n")  # an editable install is not begun
    elsewhere.mkdir()
    (elsewhere / "pallets.csv").write_text(PLAN)

    def said(*command):
        return subprocess.run(
            [environment / "bin" / command[0], *command[1:]], cwd=elsewhere, capture_output=True,
            text=True, env={"PATH": os.environ["PATH"], "HOME": str(tmp_path)},
        )  # fmt: skip

    done = said("steadyload", "warm-up")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("compiling ") == 1
    before = set(site.rglob("*.nbc"))
    assert said("steadyload", "warm-up").stderr == ""

    code = "import steadyload as sl; print(sl.__file__); print(sl.check(sl.read('pallets.csv')[0]))"
    done = said("python", "-c", code)
    assert done.returncode == 0, done.stderr
    where, answer = done.stdout.splitlines()
    assert Path(where).is_relative_to(site)
    assert answer.startswith(
        "A18 (2 boxes): fails at box 2 of 2: box 2 tips to +x, 2.8 cm; the centre of mass of "
    )
    done = said("steadyload", "check", "pallets.csv")
    assert done.returncode == 1
    assert "1 pallet: 0 stand, 1 fail" in done.stdout
    assert "compiling" not in done.stderr
    methods = ("sme", "equilibrium", "lstm_1", "lstm_e", "label@reference", "cascade@mujoco")
    words = [word for method in methods for word in ("-m", method)]
    assert "compiling" not in said("steadyload", "score", "pallets.csv", *words).stderr
    assert before
    assert set(site.rglob("*.nbc")) == before


@pytest.fixture
def clone(tmp_path, project):
    """A clone, and pip for an environment of its own, in which the clone is installed.

    All that the clone and its extra ``gym`` need is named there as installed, so that nothing is
    looked up.
    """
    for folder in FOLDERS:
        left_out = shutil.ignore_patterns("__pycache__", "published", "rows", "*.parquet")
        shutil.copytree(ROOT / folder, tmp_path / "clone" / folder, ignore=left_out)
    for file in ("setup.py", "backend.py", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, tmp_path / "clone")
    venv.create(tmp_path / "environment")
    [site] = tmp_path.glob("environment/lib/python*/site-packages")
    tools = Path(setuptools.__file__).parents[1]
    for tool in (*tools.glob("setuptools*"), tools / "_distutils_hack"):
        (site / tool.name).symlink_to(tool)
    for text in (
        project["project"]["dependencies"] + project["project"]["optional-dependencies"]["gym"]
    ):
        needed = Requirement(text)
        version = next(one.version for one in needed.specifier if one.operator == ">=")
        about = site / f"{needed.name.replace('-', '_')}-{version}.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {needed.name}\nVersion: {version}\n"
        )
    python = tmp_path / "environment" / "bin" / "python"

    def install(*words):
        """Install by pip; returns the file that is imported then."""
        subprocess.run(
            [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-index",
             "--no-build-isolation", "--disable-pip-version-check", *words],
            check=True, cwd=tmp_path / "clone",
        )  # fmt: skip
        code = "import steadyload; print(steadyload.__file__)"
        done = subprocess.run(
            [python, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path,
            env={"PATH": os.environ["PATH"]},
        )  # fmt: skip
        return Path(done.stdout.strip()).relative_to(tmp_path)

    assert install("--no-deps", "--editable", ".") == CLONED
    return install


CLONED = Path("clone", ".src", "steadyload", "__init__.py")


def test_an_extra_leaves_a_clone_what_is_imported_as_the_documentation_has_it(clone, tmp_path):
    compiled = tmp_path / "clone" / "engines" / "reference" / "__pycache__" / "compiled.nbc"
    compiled.parent.mkdir(exist_ok=True)
    compiled.touch()
    assert clone("-e", ".[gym]") == CLONED
    assert clone("steadyload[gym]") == CLONED
    assert compiled.exists()
    assert clone(".[gym]") != CLONED, "the form that no text may name"
    assert clone("-e", ".[gym]") == CLONED


def test_no_text_names_a_form_that_replaces_a_clone_by_a_copy():
    """``pip install '.[EXTRA]'`` without ``-e``; only where it is said what that does."""
    listed = subprocess.run(
        ["git", "-C", str(ROOT), "grep", "-nE", r"pip install ([^-]|-[^e]).*\.\[", "--",
         *FOLDERS, "*.md", "*.toml", "Makefile", ":!CHANGELOG.md"],
        capture_output=True, text=True,
    ).stdout.splitlines()  # fmt: skip
    harmful = [line for line in listed if re.search(r"pip install ['\"]?\.\[", line)]
    assert [line.partition(":")[0] for line in harmful] == ["docs/installing.md"]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_of_the_clone_is_refused_under_its_own_name(folder):
    done = subprocess.run(
        [sys.executable, "-c", f"import {folder}"], capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 1
    assert f"{folder} is installed as steadyload" in done.stderr.splitlines()[-1]


def test_importing_the_package_imports_nothing_heavy():
    code = "import steadyload, sys; print([m for m in sys.modules if m in ('numpy', 'pandas')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_every_public_name_is_there():
    assert {name: getattr(steadyload, name) for name in steadyload.__all__}.keys() == set(
        steadyload._PUBLIC
    )
    with pytest.raises(AttributeError, match="no attribute 'scores'"):
        steadyload.scores  # noqa: B018


def names(requirements):
    return {re.match(r"[\w.-]+", text)[0].lower() for text in requirements}


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_rapier_is_asked_for_on_the_platforms_that_it_has_a_wheel_for_and_no_other(project):
    """Wheels of 0.36.1 on https://pypi.org/project/rapier3d/#files, and no source."""
    [rapier] = [text for text in project["project"]["dependencies"] if text.startswith("rapier3d")]
    marker = Requirement(rapier).marker
    platforms = itertools.product(
        ("linux", "darwin", "win32"),
        ("x86_64", "aarch64", "arm64", "AMD64", "ARM64", "i686", "ppc64le", "x86"),
    )
    asked = {
        (system, machine)
        for system, machine in platforms
        if marker.evaluate({"sys_platform": system, "platform_machine": machine})
    }
    assert asked == {
        ("linux", "x86_64"), ("linux", "aarch64"), ("darwin", "arm64"), ("win32", "AMD64")
    }  # fmt: skip
    assert project["project"]["optional-dependencies"]["rapier"] == []


def test_the_version_is_one_and_its_changes_are_dated(project):
    """In the package, where it is cited, and in the newest dated part of the changelog."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    dated = re.findall(r"^## ([\d.]+) \((.*)\)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert dated[0] == (cited["version"], str(cited["date-released"]))
    assert cited["version"] == project["project"]["version"]


@pytest.mark.parametrize("file", sorted((ROOT / "locks").glob("*.txt")), ids=lambda file: file.stem)
def test_a_lock_file_names_all_that_is_asked_for_with_hashes(file, project):
    entries = re.split(r"\n(?=\w)", re.sub(r"^#.*\n", "", file.read_text(), flags=re.M).strip())
    assert all("==" in entry.splitlines()[0] and "--hash=sha256:" in entry for entry in entries)
    groups = project["dependency-groups"]
    asked = project["project"]["dependencies"] + groups["build"]
    if file.stem == "compiler":
        asked = groups["compiler"]
    if file.stem.startswith("site"):
        asked = groups["site"]
    if file.stem.startswith("all"):
        asked += itertools.chain(*project["project"]["optional-dependencies"].values())
    locked, python = names(entries), {"python_version": file.stem.rpartition("-")[2]}
    asked = [
        text for text in map(Requirement, asked) if not text.marker or text.marker.evaluate(python)
    ]
    assert {requirement.name.lower() for requirement in asked} <= locked
    assert ("torch" in locked) == ("numba" in locked) == file.stem.startswith("all")


@pytest.mark.parametrize("compiler", ["", "clang"])
def test_pip_is_asked_for_a_compiler_where_there_is_none_and_only_there(
    tmp_path, project, compiler
):
    if compiler:
        (tmp_path / compiler).write_text("#!/bin/sh\n")
        (tmp_path / compiler).chmod(0o755)
    code = (
        "import json, backend; print(json.dumps([backend.get_requires_for_build_wheel(), "
        "backend.get_requires_for_build_editable()]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True,
        env={"PATH": str(tmp_path)},
    )  # fmt: skip
    asked = [] if compiler else project["dependency-groups"]["compiler"]
    assert json.loads(done.stdout.splitlines()[-1]) == [asked, asked]


def test_without_a_compiler_the_build_ends_with_one_sentence(tmp_path):
    program = ROOT / "harness" / "core" / "building.py"
    (tmp_path / "sitecustomize.py").write_text("import sys\nsys.modules['ziglang'] = None\n")
    done = subprocess.run(
        [sys.executable, program, "-O3"], capture_output=True, text=True,
        env={"PATH": str(tmp_path), "PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == (
        "there is no C compiler to build the library of steadyload; allowed: $CC, cc, gcc or "
        "clang, or the Python package ziglang (pip install ziglang)\n"
    )
