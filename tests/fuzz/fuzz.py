"""Fuzzing of all formats that are read: ``python tests/fuzz/fuzz.py N [SEED] [FORMAT...]``.

``--publish`` puts the figures of a whole run on ``docs/wrong_input.md``.

Starts processes of ``trial.py``, one after the other, judges what ended one (a hang, a crash), and
writes a summary, and every input that is a finding, to ``runs/fuzz``. Ctrl-C ends it with the
summary so far.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import trial
from formats import COSTLY, FORMATS

BATCH = 20_000
"""Inputs of a process: what its libraries keep is not held against later ones."""

PAGE = Path(__file__).parents[2] / "docs" / "wrong_input.md"
BEGIN, END = "<!-- figures of fuzzing -->", "<!-- end of figures -->"
"""Lines of the page between which figures stand."""


@dataclass
class Summary:
    """What a run found."""

    seed: int
    counts: Counter = field(default_factory=Counter)
    findings: list = field(default_factory=list)
    slowest: dict = field(default_factory=dict)
    memory: float = 0.0
    seconds: float = 0.0

    def add(self, told):
        """Take over what a process told."""
        for name, kind, said, number in told["counts"]:
            self.counts[name, kind, said] += number
        self.findings += told["findings"]
        self.memory = max(self.memory, told["memory"])
        for name, (took, number) in told["slowest"].items():
            if took > self.slowest.get(name, [0.0])[0]:
                self.slowest[name] = [took, number]

    def __str__(self):
        by = defaultdict(Counter)
        for (name, kind, said), number in self.counts.items():
            by[name][kind] += number
            if said:
                by[name][said] += number
        lines = [
            f"{sum(self.counts.values()):,} inputs, seed {self.seed}, {self.seconds:.0f} s; at "
            f"most {self.memory:.1f} MB added to a process that had read every valid file once; "
            f"{len(self.findings)} findings",
            "",
            "| format | inputs | accepted | refused, by which error | findings | slowest [s] |",
            "| --- | ---: | ---: | --- | ---: | ---: |",
        ]
        for name, found in by.items():
            errors = {k: n for k, n in found.items() if k not in ("accepted", "refused", "finding")}
            total = found["accepted"] + found["refused"] + found["finding"]
            lines.append(
                f"| {name} | {total:,} | {found['accepted']:,} "
                f"| {', '.join(f'{k} {n:,}' for k, n in sorted(errors.items()))} "
                f"| {found['finding']:,} | {self.slowest.get(name, [0.0])[0]:.2f} |"
            )
        return "\n".join(lines)


def turns(names):
    """The formats of inputs in turn: those whose files take long to write and read come seldom."""
    return [n for k in range(10) for n in names if k == 0 or n not in COSTLY]


def fuzz(count, seed=0, names=tuple(FORMATS), kept=None, progress=lambda done: None):
    """Try ``count`` inputs; files of findings are kept in a folder, if one is given."""
    names = turns(names)
    summary, done, begun = Summary(seed), 0, time.monotonic()
    try:
        while done < count:
            done += _process(summary, seed, done, min(BATCH, count - done), names)
            progress(done)
    except KeyboardInterrupt:
        print("interrupted; so far:", file=sys.stderr)
    summary.seconds = time.monotonic() - begun
    if kept is not None:
        _keep(summary, kept)
    return summary


def publish(summary, page=PAGE):
    """Put a summary in the place of the figures on the page."""
    before, rest = page.read_text().split(BEGIN)
    page.write_text(f"{before}{BEGIN}\n\n{summary}\n\n{END}{rest.split(END)[1]}")


def _process(summary, seed, first, count, names):
    """One process; returns how many inputs it has dealt with, that at which it died included."""
    with tempfile.NamedTemporaryFile() as report:
        report.truncate(trial.REPORT_BYTES)
        words = [seed, first, count, report.name, *names]
        child = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("trial.py")), *map(str, words)],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip
        try:
            said = child.communicate()[1].decode(errors="replace")
        except KeyboardInterrupt:
            child.kill()
            child.communicate()
            _take(summary, Path(report.name).read_bytes())
            raise
        content = Path(report.name).read_bytes()
        _take(summary, content)
        number = int.from_bytes(content[:8], "little")
        if child.returncode == 0:
            return count
        if not content[8:9].strip(b"\0") and number == 0 and first > 0:
            raise RuntimeError(f"a process of inputs cannot begin: {said[-2000:]}")
        name = names[number % len(names)]
        ended = -child.returncode
        why = f"more than {trial.SECONDS} s of CPU" if ended == 27 else f"signal {ended}"
        why = why if ended > 0 else f"the process failed: {said[-1500:]}"
        summary.findings.append([name, number, why])
        summary.counts[name, "finding", ""] += 1
        return number + 1 - first


def _take(summary, content):
    told = content[8:].partition(b"\0")[0]
    if told:
        summary.add(json.loads(told))


def _keep(summary, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "summary.md").write_text(f"{summary}\n")
    for name, number, said in summary.findings[:200]:
        file = folder / f"{name}-{summary.seed}-{number}"
        file.write_bytes(trial.content_of(name, summary.seed, number))
        file.with_name(f"{file.name}.txt").write_text(said)


def main(words):
    published = "--publish" in words
    words = [word for word in words if word != "--publish"]
    count, seed = int(words[0]), int(words[1]) if len(words) > 1 else 0
    begun = time.monotonic()

    def progress(done):
        print(f"{done:,} inputs, {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)

    names = tuple(words[2:]) or tuple(FORMATS)
    summary = fuzz(count, seed, names, Path("runs/fuzz"), progress)
    print(summary)
    if published and sum(summary.counts.values()) >= count:
        publish(summary)
    return 1 if summary.findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
