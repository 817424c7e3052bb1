"""One process of a fuzzing run: reads mutated files in turn, and says what came of each.

``python trial.py SEED FIRST COUNT REPORT FORMAT...``: input k of a seed is the same file for ever,
of the format ``FORMAT[k % n]``. Before each, its number is written to the first eight bytes of
REPORT, so that the process that started this one knows at which it died; the rest are counts.
A timer of CPU time ends the process: what hangs in compiled code hears no exception.
"""

import json
import mmap
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

from formats import FORMATS, PLANTED

from steadyload.engines.errors import EngineInputError
from steadyload.errors import UserError

SECONDS = 2.0
MEMORY = 500 * 2**20
REPORT_BYTES = 8 + (1 << 20)
LONGEST_SENTENCE = 2_000


def content_of(name, seed, number):
    """The mutated file of a number."""
    chosen, draw = ({**FORMATS, **PLANTED})[name], random.Random(f"{name}:{seed}:{number}")
    return chosen.mutate(draw.choice(chosen.seeds()), draw)


def wrong_sentence(error):
    """What is wrong with the message of a named error, if anything."""
    text = str(error)
    if len(text) > LONGEST_SENTENCE:
        return f"a message of {len(text)} characters"
    if not text.isprintable():
        return "a message with control characters"
    return ""


def outcome(read, path):
    """``accepted``, ``refused`` with the name of the error, or ``finding`` with what is wrong."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            error = read(path)
    except (UserError, EngineInputError) as raised:
        error = raised
    except OSError as raised:
        if raised.filename is None:
            return "finding", "".join(traceback.format_exception(raised)[-8:])
        error = raised
    except Exception as raised:
        return "finding", "".join(traceback.format_exception(raised)[-8:])
    if error is None:
        return "accepted", ""
    wrong = wrong_sentence(error)
    if wrong:
        return "finding", f"{type(error).__name__}: {wrong}: {str(error)[:200]!a}"
    return "refused", type(error).__name__


def used():
    """Bytes of memory that this process addresses."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def peak():
    """The most memory that this process has had at a time [KiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main(arguments):
    seed, first, count, report = int(arguments[0]), *map(int, arguments[1:3]), arguments[3]
    names = arguments[4:]
    known = {**FORMATS, **PLANTED}
    with Path(report).open("r+b") as file:
        shared = mmap.mmap(file.fileno(), REPORT_BYTES)
    counts, findings, slowest = Counter(), [], {}

    def tell():
        told = json.dumps(
            {
                "counts": [[*key, n] for key, n in counts.items()],
                "findings": findings[-40:],
                "slowest": slowest,
                "memory": (peak() - warm) / 1024,
            }
        ).encode()
        shared[8 : 8 + len(told) + 1] = told + b"\0"

    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as made:
        folder = Path(made)
        for name in names:
            known[name].warm(folder)
        warm = peak()
        resource.setrlimit(resource.RLIMIT_AS, (used() + MEMORY, resource.RLIM_INFINITY))
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        for number in range(first, first + count):
            name = names[number % len(names)]
            shared[:8] = number.to_bytes(8, "little")
            content = content_of(name, seed, number)
            path = known[name].place(folder, content)
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            begun = time.process_time()
            kind, said = outcome(known[name].read, path)
            took = time.process_time() - begun
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            counts[name, kind, said if kind == "refused" else ""] += 1
            if took > slowest.get(name, [0.0])[0]:
                slowest[name] = [took, number]
            if kind == "finding":
                findings.append([name, number, said[-3000:]])
            if kind == "finding" or number % 50 == 0:
                tell()
        tell()
        shared[:8] = (first + count).to_bytes(8, "little")


if __name__ == "__main__":
    main(sys.argv[1:])
