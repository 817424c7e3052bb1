"""Every error of the package survives the way between two processes."""

import importlib
import io
import pickle
import pkgutil
import signal
from pathlib import Path

import steadyload as sl
from steadyload.atomic import LinkError
from steadyload.layouts.benchmark.tables import DamagedSetError
from steadyload.layouts.files.sources import MissingFileError
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.growing import MisplacedError
from steadyload.layouts.model.item import LayoutError
from steadyload.properties.property import Violation
from steadyload.reading import TooLargeError
from steadyload.runs.store import DamagedError
from steadyload.runs.worker import Phase, ProcessDiedError
from steadyload.stored import StoredFileError

BOX = sl.Item(0, (0, 0, 0), (40, 30, 40), 12)
FILE = Path("folder/a file")


def located(kind):
    return kind(
        "is too wide; allowed: 120", file="a.csv", layout="A18", item="3", frame=Frame(unit="mm")
    )


MADE = {
    DamagedError: lambda kind: kind(FILE),
    DamagedSetError: lambda kind: kind(FILE),
    LayoutError: located,
    LinkError: lambda kind: kind(FILE),
    MisplacedError: lambda kind: kind(sl.Pallet(120, 160, 80), (BOX,), BOX),
    OSError: lambda kind: kind(2, "No such file or directory", str(FILE)),
    ProcessDiedError: lambda kind: kind(-signal.SIGSEGV, Phase.WORKING),
    StoredFileError: lambda kind: kind(FILE, "restore it"),
    TooLargeError: lambda kind: kind(FILE, 1024, 4096),
    Violation: lambda kind: kind("it moves", steps=3),
}
"""How an error is made whose class, or the nearest of its bases here, has a constructor."""


def below(kind):
    for inner in kind.__subclasses__():
        yield inner
        yield from below(inner)


def error_classes():
    for module in pkgutil.walk_packages(sl.__path__, "steadyload."):
        if module.name.rpartition(".")[2] != "__main__":
            try:
                importlib.import_module(module.name)
            except ModuleNotFoundError as error:  # an engine's library that is not installed
                assert not str(error.name).startswith("steadyload")  # noqa: PT017
    return {kind for kind in below(BaseException) if is_own(kind)}


def is_own(kind):
    return kind.__module__.startswith("steadyload.")


def made(kind):
    nearest = next(
        (
            base
            for base in kind.__mro__
            if base in MADE or (is_own(base) and "__init__" in vars(base))
        ),
        None,
    )
    return MADE[nearest](kind) if nearest else kind("it is 3; allowed: 4", 5)


def sent(error):
    """The error as another process gets it, without what Dask registers for all exceptions."""
    content = io.BytesIO()
    pickler = pickle.Pickler(content)
    pickler.dispatch_table = {}
    pickler.dump(error)
    return pickle.loads(content.getvalue())


def state(error):
    return type(error), error.args, str(error), vars(error)


def test_every_error_is_the_same_after_it_was_sent_to_another_process():
    classes = error_classes()
    assert len(classes) > 60
    for kind in sorted(classes, key=lambda kind: kind.__qualname__):
        error = made(kind)
        error.add_note("on another machine")
        error.place = "a place"
        assert state(error) == state(sent(error)), kind


def test_an_error_whose_message_was_not_read_says_the_same_after_it_was_sent():
    error = made(MisplacedError)
    assert str(sent(error)) == str(error)


def test_a_sent_error_names_the_file_that_is_missing():
    assert sent(made(MissingFileError)).filename == str(FILE)
