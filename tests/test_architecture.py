"""Who may import whom, and who may open files: no arrow runs back up, and there is no circle."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from steadyload.engines.registry import ENGINES
from steadyload.methods.registry import METHODS, presets

ROOT = Path(__file__).parents[1]

FOLDERS = {"harness": "", "engines": "engines.", "learners": "learners.", "reports": "reports."}
"""Folder of the repository -> where it is installed below ``steadyload``."""

_LAYOUTS = {
    "core", "layouts", "statistics", "atomic", "errors", "escaping", "numbers",
    "reading", "stored", "notebook", "plugins", "progress", "config",
}  # fmt: skip
_METHODS = {"methods", "engines", "statics", "time_limit", *_LAYOUTS}
_RUNS = {"runs", "reports", *_METHODS}
_LIBRARIES = {
    "labelling",
    "tuning",
    "properties",
    "learners",
    "transport",
    "repairing",
    "measured",
    *_RUNS,
}

# Package below ``steadyload`` -> what of ours it may import. ``cli`` may import everything.
ALLOWED = {
    "statistics": {"statistics"},
    "errors": {"escaping"},
    "escaping": set(),
    "numbers": {"errors", "escaping"},
    "plugins": {"errors"},
    "progress": set(),
    "notebook": set(),
    "config": {"engines", "numbers", "errors", "escaping"},
    "time_limit": {"errors", "numbers"},
    "reports": {"reports", "statistics", "atomic", "errors", "escaping", "reading"},
    "core": {"core", "errors"},
    "statics": {"statics", "engines", "time_limit", *_LAYOUTS},
    "engines": {"engines", "plugins"},
    "atomic": {"errors"},
    "reading": {"errors", "escaping"},
    "stored": {"atomic", "errors", "escaping", "reading"},
    "layouts": _LAYOUTS,
    "methods": _METHODS,
    "runs": _RUNS,
    "gym": {"gym", *_METHODS},
    "transport": {"transport", *_METHODS},
    "repairing": {"repairing", *_METHODS},
    "measured": {"measured", "transport", *_METHODS},
    "labelling": {"labelling", *_RUNS},
    "tuning": {"tuning", *_RUNS},
    "properties": {"properties", "transport", *_RUNS},
    "learners": {"learners", *_RUNS},
    "app": {"app", "reports", "transport", "repairing", *_RUNS},
    "studies": {"studies", "app", "reports", *_LIBRARIES},
    "cli": {"cli", "studies", "app", "reports", *_LIBRARIES},
}

ROOMS = {
    "core": set(),
    "engines": set(),
    "engines.reference": {"engines"},
    "engines.checks": {"engines"},
    "reports": set(),
    "reports.templates": set(),
    "reports.charts": {"reports"},
    "reports.viewer": {"reports"},
    "reports.pages": {"reports", "reports.charts", "reports.viewer"},
    "layouts.model": set(),
    "layouts.files": {"layouts.model"},
    "layouts.packing": {"layouts.model"},
    "layouts.packers": {"layouts.model", "layouts.files"},
    "layouts": {"layouts.model", "layouts.files", "layouts.packers"},
    "layouts.rewriting": {"layouts", "layouts.model", "layouts.files", "layouts.packers"},
    "layouts.benchmark": {"layouts", "layouts.model", "layouts.files"},
    "statics": set(),
    "statics.bearing": {"statics"},
    "methods.contract": set(),
    "methods.rules": {"methods.contract"},
    "methods.simulation": {"methods.contract"},
    "methods.equilibrium": {"methods.contract", "methods.rules", "methods.simulation"},
    "methods": {"methods.contract", "methods.simulation"},
    "methods.cascade": {"methods", "methods.contract"},
    "methods.session": {"methods", "methods.contract", "methods.simulation", "methods.cascade"},
    "app.recommend": set(),
    "app": {"app.recommend"},
    "learners": set(),
    "learners.plans": {"learners"},
    "labelling.building": set(),
    "labelling": {"labelling.building"},
    "tuning": set(),
    "tuning.cascade": {"tuning"},
}  # fmt: skip
"""Folder -> other folders of its package that it may import. The name of a package alone is of
the modules that lie in no folder of it."""

SHOWING = ("page", "figures", "section", "sections")
"""Endings of the modules of studies and app that show something: only these may import the kit.
Rows are declared with their columns, by whatever computes them."""

UPWARD = {
    "__init__": "the public interface, by name",
    "methods.registry": "learned methods, by name",
    "notebook": "what draws in a notebook, by name",
}
"""Modules that name modules of a higher floor as strings, and why."""


def module_name(path, root=ROOT):
    folder, *parts = path.relative_to(root).with_suffix("").parts
    return (FOLDERS[folder] + ".".join(parts)).removesuffix(".__init__")


def modules(root=ROOT):
    return {
        module_name(path, root): path
        for folder in FOLDERS
        for path in sorted((root / folder).rglob("*.py"))
    }


def imports(path, known):
    """What of ours a file imports, wherever it does so, as module names below ``steadyload``."""
    for node in nodes(path.read_text()):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            top, _, rest = name.partition(".")
            assert top not in FOLDERS, f"{path} imports {name}"
            if top == "steadyload":
                yield rest if rest in known else rest.rpartition(".")[0]


def floor(name):
    """The package of a module."""
    return name.partition(".")[0]


@cache
def nodes(source):
    """All nodes of the syntax tree of a module."""
    return tuple(ast.walk(ast.parse(source)))


@pytest.fixture(autouse=True, scope="module")
def forgotten():
    """Trees of all modules are not kept for other tests: they make collecting garbage slow."""
    yield
    nodes.cache_clear()


def faults(root):
    """Every arrow that may not be, and every circle."""
    known = modules(root)
    arrows = {name: set(imports(path, known)) for name, path in known.items()}
    for name, targets in arrows.items():
        if name in ("", "__init__"):
            continue  # it names the public interface, and imports what is asked for
        for target in sorted(targets):
            if floor(target) not in ALLOWED[floor(name)]:
                yield f"{name} imports {target}"
            shown = floor(target) == "reports" and target not in {
                "reports.columns",
                "reports.frame_points",
                "reports.frame_columns",
                "reports.frames",
            }
            if floor(name) != "cli" and floor(name) != "reports" and shown and not shows(name):
                yield f"{name} computes, and imports {target}"
    arrows = {name: targets - {name} for name, targets in arrows.items() if name}
    yield from circles(arrows)
    folders = between_folders(arrows)
    yield from (f"{fault} of folders" for fault in circles(folders))
    for room, targets in folders.items():
        for target in sorted(targets):
            if room in ROOMS and floor(target) == floor(room) and target not in ROOMS[room]:
                yield f"{room} imports {target}"
    studies = {room for room in folders if room.startswith("studies.")}
    for room in studies:
        yield from (f"{room} imports {target}" for target in studies & folders[room])


def between_folders(arrows):
    """Folder -> folders that its modules import; a module of no folder is one by itself."""
    packages = {name.rpartition(".")[0] for name in arrows}

    def folder(name):
        return name if name in packages else name.rpartition(".")[0] or name

    found = {}
    for name, targets in arrows.items():
        found.setdefault(folder(name), set()).update(map(folder, targets))
    return {name: targets - {name} for name, targets in found.items()}


def shows(name):
    return name.endswith(SHOWING) or name in ("app.viewing", "studies.kit")


def circles(arrows):
    """A line for every module that is reached from itself."""
    for name in arrows:
        seen, ahead = set(), list(arrows[name])
        while ahead:
            target = ahead.pop()
            if target == name:
                yield f"{name} is part of a circle"
                break
            if target not in seen:
                seen.add(target)
                ahead += arrows.get(target, ())


def test_only_reports_draws():
    drawing = {
        name
        for name, path in modules().items()
        if floor(name) != "reports" and re.search(r"(from|import) matplotlib", path.read_text())
    }
    assert not drawing


def test_imports_point_down_and_there_is_no_circle():
    assert list(faults(ROOT)) == []


def test_every_room_of_a_package_is_listed():
    names = between_folders({name: () for name in modules() if name})
    floors = {floor(room) for room in ROOMS}
    assert {name for name in names if floor(name) in floors} == set(ROOMS)


@pytest.mark.parametrize(
    ("file", "line", "fault"),
    [
        ("harness/runs/labels.py", "import steadyload.app.viewing",
         "runs.labels imports app.viewing"),
        ("reports/table.py", "from steadyload.layouts.model.layout import Layout",
         "reports.table imports layouts.model.layout"),
        ("harness/app/recommend/front.py", "from steadyload.reports.table import percent",
         "app.recommend.front computes, and imports reports.table"),
        ("harness/core/whole.py", "import steadyload.layouts.model.layout",
         "core.whole imports layouts.model.layout"),
        ("harness/layouts/model/contacts.py", "import steadyload.statics.balance",
         "layouts.model.contacts imports statics.balance"),
        ("engines/errors.py", "if TYPE_CHECKING:\n    from steadyload.engines.world import World",
         "engines.errors is part of a circle"),
        ("harness/methods/simulation/scene.py", "import steadyload.methods.equilibrium.settling",
         "methods.simulation imports methods.equilibrium"),
        ("harness/methods/contract/declared.py", "import steadyload.methods.rules.sme",
         "methods.contract imports methods.rules"),
        ("harness/studies/scope/comparing.py", "import steadyload.studies.scale.study",
         "studies.scope imports studies.scale"),
        ("harness/tuning/identity.py", "import steadyload.tuning.cascade.evaluation",
         "tuning is part of a circle of folders"),
    ],
)  # fmt: skip
def test_a_wrong_arrow_is_found(tmp_path, file, line, fault):
    for name, path in modules().items():
        if name:
            copy = tmp_path / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    with (tmp_path / file).open("a") as changed:
        changed.write(f"\nfrom typing import TYPE_CHECKING\n{line}\n")
    assert fault in set(faults(tmp_path))


def test_modules_of_a_higher_floor_are_named_in_registries_only():
    known = modules()
    found = set()
    for name, path in known.items():
        for node in nodes(path.read_text()):
            if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
                continue
            target, colon, _ = node.value.removeprefix("steadyload.").partition(":")
            if colon and node.value.startswith("steadyload.") and target in known:
                if floor(name or "__init__") not in ALLOWED:
                    found.add("__init__")
                elif floor(target) not in ALLOWED[floor(name)]:
                    found.add(name)
    assert found == set(UPWARD)


def taken_of(module, path):
    """Names that a file imports from a module of ours."""
    for node in nodes(path.read_text()):
        if isinstance(node, ast.ImportFrom) and node.module == f"steadyload.{module}":
            yield from (alias.name for alias in node.names)


def test_methods_are_compared_in_one_place():
    """Tests and corrections are of `runs`; others take what pages state: the level, the power."""
    stated = {"LEVEL", "detectable"}
    users = {
        name: {*taken_of("statistics.paired", path)} - stated for name, path in modules().items()
    }
    assert {name for name, taken in users.items() if taken} == {"runs.comparison"}


def test_files_are_small_and_shadow_no_library():
    shadows = {"pybullet", "mujoco", "dartpy", "pymunk", "pydrake", "torch", "utils"}
    files = modules().values()
    assert not [path for path in files if path.stem in shadows]
    assert not [path for path in files if len(path.read_text().splitlines()) > 420]


NAMES = {*ENGINES, *METHODS, *presets()}
STARTS = {"fbs", "pbs", "ps", "lstm", *NAMES}
"""Names of methods and engines, and how names of a kind start."""

NAMING = {
    "engines.registry": "the engines",
    "methods.registry": "the methods",
    "methods.tuned": "the presets that searches find",
    "labelling.screened_loading": "the two simulations that screen large layouts",
    "reports.style": "their colours and markers",
    "tuning.cascade.defaults": "stages of a cascade, each with parameters, in order",
}
"""Modules that list methods or engines by name, and why; others ask a registry by trait. Studies
name those that they compare."""


def named(text):
    """The method or engine that a text is of; else the text."""
    return text.partition("@")[0].partition(":")[0]


def named_in(node):
    """Names of methods and engines that a node asks for: in a comparison, or as an ending."""
    ends = isinstance(node, ast.Call) and getattr(node.func, "attr", "") in (
        "startswith",
        "endswith",
    )
    if not ends and not isinstance(node, ast.Compare):
        return set()
    values = {n.value for n in ast.walk(node) if isinstance(n, ast.Constant)}
    texts = {value for value in values if isinstance(value, str)}
    if ends:
        return {text for text in texts if named(text).strip("_-") in STARTS}
    return {text for text in texts if named(text) in NAMES}


def lists(node):
    """Names of methods and engines that a literal holds."""
    elements = node.keys if isinstance(node, ast.Dict) else getattr(node, "elts", ())
    values = {element.value for element in elements if isinstance(element, ast.Constant)}
    return {value for value in values if isinstance(value, str) and named(value) in NAMES}


def test_methods_and_engines_are_named_in_no_condition():
    for path in modules().values():
        for node in nodes(path.read_text()):
            assert not named_in(node), f"{path}:{node.lineno}"


def test_methods_and_engines_are_listed_in_registries():
    listing = {
        name
        for name, path in modules().items()
        if floor(name) != "studies"
        and any(len(lists(node)) > 1 for node in nodes(path.read_text()))
    }
    assert listing == {*NAMING}


@pytest.mark.parametrize(
    "line",
    ['spec == "lstm_1"', 'spec.startswith("lstm")', 'spec in ("sme", "x")', 'engine != "mujoco"'],
)
def test_a_condition_on_a_name_is_found(line):
    assert any(named_in(node) for node in ast.walk(ast.parse(line)))


PROGRESS = re.compile(r"^(class )?(Named)?Progress( =|\()|Callable\[\[int, int\], None\]", re.M)


def test_progress_is_defined_once():
    defining = {name for name, path in modules().items() if PROGRESS.search(path.read_text())}
    assert defining - {"studies.convergence.study"} == {"progress"}


FREE = {
    "core.building": "the source of the C library",
    "core.library": "the headers of the C library",
    "reading": "the one place",
    "cli": "the null device, for a standard stream that is closed",
    "layouts.files.parquet_rows": "an open layout file, after its size and footer were looked at",
    "layouts.parquet_reader": "an open file of layouts that a run wrote",
    "runs.blocks": "the file of layouts that this run wrote",
    "layouts.files.sources": "a layout file, a pipe, standard input, as far as its format allows",
    "studies.kept_rows": "an archive in memory",
    "runs.store": "the lock of a folder, of which nothing is read",
    "reports.pages.writing": "a folder, to lock it",
    "atomic": "writes",
    "tuning.ledger": "writes",
    "engines.reference.compilation": "the source of the program",
    "runs.provenance": "the source of the program, and the kind of processor",
    "engines.checks.protocol": "the memory of this process",
    "studies.scale.needs": "the memory of this process",
    "engines.with_bullet": "the null device",
    "cli.terminal": "the null device",
    "cli.demo": "a page in the browser",
}
"""Modules that open something by themselves, and what."""

OPENING = {"read_text", "read_bytes", "open", "fromfile", "loadtxt", "genfromtxt", "memmap"}
"""Functions that open a file, whosever they are."""

OPENING_OF = {
    f"{module}.{name}"
    for module in ("np", "json", "tomllib", "pickle", "pq", "pd")
    for name in ("load", "read_table", "read_csv", "read_parquet", "ParquetFile")
}
"""Functions of libraries that take a file or a path."""


def openings(path):
    """Calls that open a file which is none of the package."""
    for node in nodes(path.read_text()):
        if isinstance(node, ast.Call):
            call = ast.unparse(node)
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            opens = name in OPENING or ast.unparse(node.func) in OPENING_OF
            if opens and "resources.files(" not in call and "BufferReader(" not in call:
                yield f"{node.lineno}: {call[:80]}"


def test_no_file_is_read_past_the_reader():
    found = {name: list(openings(path)) for name, path in modules(ROOT).items()}
    opened = {name: calls for name, calls in found.items() if calls}
    others = {name: opened[name] for name in opened.keys() - FREE.keys()}
    assert not others, "read by steadyload.reading, or say in FREE why something else is opened"
    assert FREE.keys() <= opened.keys()


def test_toml_is_parsed_in_one_place():
    found = {name for name, path in modules().items() if "import tomllib" in path.read_text()}
    assert found == {"reading"}


def test_a_file_that_is_read_otherwise_is_found(tmp_path):
    path = tmp_path / "reads.py"
    path.write_text(
        'text = Path("x").read_text()\nfile = open("x")\ntable = pq.read_table("x")\n'
        'ours = resources.files("x").joinpath("y").read_text()\n'
        "kept = pq.read_table(pa.BufferReader(content))\n"
    )
    assert [found.partition(":")[0] for found in openings(path)] == ["1", "2", "3"]


def without_encoding(path):
    """Lines of a file that read or write text in whatever encoding the machine has."""
    for node in nodes(path.read_text()):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        of = getattr(getattr(node.func, "value", None), "id", "")
        keys = {keyword.arg for keyword in node.keywords}
        modes = [
            argument.value
            for argument in [*node.args, *(k.value for k in node.keywords if k.arg == "mode")]
            if isinstance(argument, ast.Constant) and isinstance(argument.value, str)
        ]
        opens = name in {"open", "fdopen"} and of not in {"os", "webbrowser", "tarfile", "zipfile"}
        text = (
            name in {"read_text", "write_text"}
            or (opens and not any("b" in mode for mode in modes))
            or (of == "subprocess" and "text" in keys)
        )
        if text and "encoding" not in keys:
            yield node.lineno


def test_text_files_are_read_and_written_as_utf_8():
    found = {path: list(without_encoding(path)) for path in modules().values()}
    assert {path: lines for path, lines in found.items() if lines} == {}
