"""How the command begins and ends: imports, exit statuses, interrupts, words that help."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from steadyload.cli import main, running
from steadyload.cli.commands import TOPICS, commands
from steadyload.errors import FailedError
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts

HEAVY = {"numpy", "scipy", "pandas", "matplotlib", "numba", "torch", "pyarrow", "mujoco", "jinja2"}


def fresh(*words, **more):
    return subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, timeout=600, **more
    )


def interruptible(*words, **more):
    """A fresh Python that takes interrupts as a terminal's does, whoever started the tests."""
    return fresh(
        *words, **more,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["--help"], 0),
        ([], 0),
        (["score", "--halp", "x.json"], 2),
        (["scroe", "x.json"], 2),
        (["benchmark"], 0),
        (["study", "evaluation", "--help"], 0),
    ],
)
def test_help_and_mistyped_words_import_nothing_heavy(words, status):
    code = "import sys; from steadyload.cli import main; s = main(sys.argv[1:]); "
    done = fresh("-c", code + "print(s, *sys.modules, file=sys.stderr)", *words)
    ended, *loaded = done.stderr.splitlines()[-1].split()
    assert int(ended) == status
    assert not HEAVY & set(loaded)


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("words", "status"),
    [
        ("--version", 0),
        ("--help", 0),
        ("methods sme", 0),
        ("scroe", 2),
        ("check one.json -m sme", 0),
        ("check falls.json -m sme", 1),
        ("check - -m sme", 2),
    ],
)
def test_a_closed_standard_stream_changes_no_status(tmp_path, words, status, closed):
    """Only what is read of it: nothing. No file of the command gets its number."""
    if "<&-" not in closed:
        closed += " </dev/null"
    boxes = [Item(k, (10.0 * k, 10.0 * k, 0.0), (10.0, 10.0, 10.0), 1.0) for k in range(2)]
    for name, some in (("one.json", boxes[:1]), ("falls.json", boxes)):
        layout = Layout("one", Pallet(80.0, 80.0, 80.0), tuple(some))
        write_layouts(tmp_path / name, [layout], Format.NATIVE)
    code = "import sys; from steadyload.cli import command; sys.exit(command())"
    done = subprocess.run(
        ["sh", "-c", f'"$0" -c "$1" {words} {closed}', sys.executable, code],
        cwd=tmp_path, capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    if words.startswith("check - ") and "2>&-" not in closed:
        assert done.stderr == "steadyload: standard input: is empty\n"


@pytest.mark.parametrize("boxes", [4, 30])
def test_a_check_of_one_pallet_imports_what_it_needs(tmp_path, boxes):
    """In the command and in the process beside it, by the default for so many boxes."""
    items = [Item(k, (10.0 * k, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0) for k in range(boxes)]
    write_layouts(
        tmp_path / "one.json",
        [Layout("one", Pallet(300.0, 80.0, 80.0), tuple(items))],
        Format.NATIVE,
    )
    code = "import sys; from steadyload.cli import main; sys.exit(main(sys.argv[1:]))"
    done = fresh("-X", "importtime", "-c", code, "check", str(tmp_path / "one.json"))
    assert "1 pallet: 1 stand" in done.stdout
    loaded = re.findall(r"^import time: .*\| +(\S+)$", done.stderr, re.MULTILINE)
    assert "steadyload.core.library" in loaded
    assert not {"numba", "pandas", "pyarrow", "scipy.optimize", "scipy.special"} & set(loaded)


def test_a_check_of_one_pallet_says_that_it_compiles(tmp_path):
    """The process beside the command compiles, and says so."""
    boxes = (Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),)
    layouts = [Layout("one", Pallet(80.0, 80.0, 80.0), boxes)]
    write_layouts(tmp_path / "one.json", layouts, Format.NATIVE)
    code = "import sys; from steadyload.cli import main; sys.exit(main(sys.argv[1:]))"
    words = ("-c", code, "check", "-m", "label@reference", str(tmp_path / "one.json"))
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "compiled")}
    said = [fresh(*words, env=place).stderr.count("compiling the reference") for _ in range(2)]
    assert said == [1, 0]


def test_every_configuration_is_light():
    listing = (
        "import sys; from steadyload.studies.registry import studies, study; "
        "print([study(n).answers for n in studies()], file=sys.stderr); print(*sys.modules)"
    )
    done = fresh("-c", listing)
    assert done.returncode == 0, done.stderr
    assert not HEAVY & set(done.stdout.split())


def test_all_commands_load_and_tell_their_flags(capsys):
    for words, command in commands().items():
        assert main([*words.split(), "--help"]) == 0
        told = capsys.readouterr().out
        assert f"Usage: steadyload {words}" in told
        assert command.about.split()[0] in told
    assert {words.split()[0] for words in commands() if " " in words} == set(TOPICS)


def test_the_help_lists_commands_in_groups(capsys):
    assert main([]) == 0
    told = capsys.readouterr().out
    places = [told.index(f" {group} ─") for group in ("Use", "Compare", "Build", "Remake")]
    assert places == sorted(places)
    for words in commands():
        assert f"\n│ {words.split()[0]} " in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["scroe"], "unknown command 'scroe'; did you mean 'score'? allowed: benchmark, "),
        (["study", "convergense"], "unknown action 'convergense' of study; did you mean"),
        (
            ["score", "x", "--metod", "sme"],
            "score: unknown flag '--metod'; did you mean '--method'",
        ),
        (["score", "x", "--columns", "x=a", "y=b"], "score: nothing takes 'y=b'; allowed: "),
        (["score", "--halp"], "score: unknown flag '--halp'; did you mean '--help'?"),
        (["score", "x", "-q"], "score: unknown flag '-q'; allowed: --profile, "),
        (["score", "x", "--limit", "0"], "--limit: '0'; allowed: a whole number, 1 or more"),
        *(
            (
                ["score", "x", "--timeout", text],
                f"--timeout: {text!r}; allowed: a number above 0 and below 1,000,000,000",
            )
            for text in ("no", "0", "1e308", "inf", "1e400", "1e9")
        ),
        (["score", "x", "--overhang", "1e5"], "'1e5'; allowed: a number, 0 or more, below 100,000"),
        (
            ["study", "evaluation", "--question", "stnds"],
            "--question: 'stnds'; did you mean 'stands'? allowed: ",
        ),
        (["study", "closed-forms", "--work"], "--work"),
        (
            ["study", "uncertain", "--config", "no.toml"],
            "steadyload: no.toml: No such file or directory\n",
        ),
        *(
            (
                ["reality", "field", "x", "--deck-friction", text],
                f"--deck-friction: {text!r}; allowed: a number, 0 to 10",
            )
            for text in ("nan", "11", "-1", "x", "\u0663")
        ),
    ],
)
def test_a_wrong_word_is_one_sentence_that_names_the_nearest(words, message, capsys):
    assert main(words) == 2
    told = capsys.readouterr()
    assert message in told.err
    assert told.err.splitlines()[-1].startswith("steadyload: ")
    assert not told.out


def test_flags_right_after_a_topic_are_of_its_study(capsys):
    words = ["--data", "x.csv", "--limit", "40", "-o", "page"]
    short, whole = (
        running.command_of([*first, *words]) for first in (["reality"], ["study", "reality"])
    )
    assert vars(short) == vars(whole)
    assert (short.data, short.limit) == (Path("x.csv"), 40)
    assert main(["reality", "--help"]) == 0
    assert "field" in capsys.readouterr().out
    assert main(["reality", "--dta", "x.csv"]) == 2
    assert "study reality: unknown flag '--dta'; did you mean '--data'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["--meth", "sme", "-m", "fbs", "--lim=3"],
        ["-m", "sme", "--method=fbs", "--limit", "9", "--limit", "3"],
        ["-msme", "-m=fbs", "--limit", "3"],
    ],
)
def test_flags_may_be_cut_joined_and_repeated(words):
    made = running.command_of(["score", "x.json", *words])
    assert (made.methods, made.limit) == (("sme", "fbs"), 3)


def test_a_flag_may_take_several_values_one_or_none():
    fitted = running.command_of(["cascade", "fit", "--error-budget", "0.5", "1", "--limit", "4"])
    assert (fitted.error_budget, fitted.limit) == ((0.5, 1.0), 4)
    assert running.command_of(["study", "learned", "--foreign", "--limit", "4"]).foreign == ()
    shipped = [running.command_of(["train", *w]).ship for w in ([], ["--ship"], ["--ship", "x"])]
    assert shipped == [None, "", "x"]


def test_failed_work_has_status_1_and_an_interrupt_130(monkeypatch, capsys):
    for error, status, told in (
        (FailedError("workers died"), 1, "steadyload: workers died\n"),
        (KeyboardInterrupt(), 130, "steadyload: interrupted\n"),
    ):

        def fail(words, error=error):
            raise error

        monkeypatch.setattr(running, "command_of", fail)
        assert main(["score"]) == status
        assert capsys.readouterr().err == told


def test_an_interrupted_import_is_an_interrupt(monkeypatch, capsys):
    """Some libraries raise an error of their own when theirs is interrupted."""

    def fail(words):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise ImportError("initialization failed") from error

    monkeypatch.setattr(running, "command_of", fail)
    assert main(["score"]) == 130
    assert capsys.readouterr().err == "steadyload: interrupted\n"


def test_ctrl_c_while_libraries_are_imported_is_one_line(tmp_path):
    """The interrupt comes when numpy is asked for: what stands in its place sends it."""
    (tmp_path / "numpy.py").write_text(
        "import os, signal\nexec('os.kill(os.getpid(), signal.SIGINT)')\nraise ImportError\n"
    )
    done = interruptible(
        "-m", "steadyload.cli", "methods",
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])},
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "steadyload: interrupted\n")


INTERRUPT = "os.kill(os.getpid(), signal.SIGINT)"


@pytest.mark.parametrize(
    ("work", "at_exit"),
    [
        ("", INTERRUPT),
        (INTERRUPT, INTERRUPT),
        (f"try:\n        {INTERRUPT}\n    finally:\n        raise RuntimeError", ""),
    ],
    ids=["after the work", "twice", "turned into another error"],
)
def test_ctrl_c_is_one_line_whenever_it_comes(work, at_exit):
    code = (
        "import atexit, os, signal, sys\n"
        "from steadyload.cli import command, interrupts, running\n"
        "def run(words):\n    interrupts.working()\n"
        f"    atexit.register(lambda: {at_exit or None})\n    {work}\n    return 0\n"
        "running.run = run\nsys.exit(command())\n"
    )
    done = interruptible("-c", code)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "steadyload: interrupted\n")


def test_an_interrupt_that_python_cannot_raise_comes_again_and_the_work_is_cleaned_up():
    """In a destructor or a callback of the garbage collector an exception goes no further."""
    code = (
        "import os, pathlib, signal, sys, time\n"
        "from steadyload.cli import command, running, terminal\n"
        "def run(words):\n    with terminal.resumable(pathlib.Path('run')):\n"
        f"        type('', (), {{'__del__': lambda self: {INTERRUPT}}})()\n        time.sleep(60)\n"
        "running.run = run\nsys.exit(command())\n"
    )
    done = interruptible("-c", code)
    assert (done.returncode, done.stderr) == (
        130,
        "steadyload: interrupted; what is finished stays in run, and the same command goes on\n",
    )


def test_little_is_imported_before_interrupts_are_ours():
    """Until then Ctrl-C ends with Python's traceback."""

    def imported(names):
        done = fresh("-c", f"import sys, {names}; print(*sys.modules)")
        assert done.returncode == 0, done.stderr
        return {name for name in done.stdout.split() if name.split(".")[0] != "steadyload"}

    assert imported("steadyload.cli") <= imported("__future__, atexit, signal")


def test_a_file_says_what_flags_would_and_flags_override_it(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('methods = ["sme", "fbs"]\nlimit = 4\nwork = "here"\n')
    made = running.command_of(["study", "evaluation", "--config", str(file), "--limit", "6"])
    assert (made.methods, made.limit, str(made.work)) == (("sme", "fbs"), 6, "here")
    assert made.asked == "within"
    file.write_text("second_model = true\nlimit = 3\n")
    made = running.command_of(["study", "convergence", "--config", str(file)])
    assert (made.second_model, made.limit, made.asked) == (True, 3, "within")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("limitt = 3", "unknown key 'limitt'; did you mean 'limit'"),
        ("limit = 1", "limit is 1; allowed: a whole number, 2 or more"),
        ("limit = true", "limit is True; allowed: a whole number, 2 or more"),
        ('methods = "sme"', "methods is 'sme'; allowed: a list"),
        ("limit =", "mine.toml: "),
    ],
)
def test_a_wrong_file_is_one_sentence(tmp_path, text, message, capsys):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    assert main(["study", "evaluation", "--config", str(file)]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert str(file) in told
    assert told.count("\n") == 1
