"""What is run for each page, and which of its values clocks decide: ``pages.toml``."""

from __future__ import annotations

import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

from facts import CLOCK, Mask, Page, masked, read_page

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PUBLISHED = ROOT / "reports" / "published"

_ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")} | {
    "PYTHONDONTWRITEBYTECODE": "1"
}


class RunError(Exception):
    """A command of a page did not end as it should."""


@dataclass(frozen=True)
class Definition:
    """How a small page is made, and what of it clocks decide.

    Attributes:
        name: of the page.
        run: command lines without the word ``steadyload``, in order; `> FILE` keeps what one
            prints; ``{root}`` is the checkout.
        report: the page, below the work folder; empty where a run makes none.
        published: name of the published page of this kind.
        status: exit statuses that are right.
        clock_cells: patterns over "heading | first cell | column"; a match masks the whole cell.
        clock_text: patterns; what they match in a cell or sentence is masked.
        dropped: patterns of sentences that stand on a page only at some times.
    """

    name: str
    run: tuple[str, ...] = ()
    report: str = "page/report.md"
    published: str = ""
    status: tuple[int, ...] = (0,)
    clock_cells: tuple[str, ...] = ()
    clock_text: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()

    def mask(self) -> Mask:
        """Masks what clocks decide."""
        whole = [re.compile(pattern) for pattern in self.clock_cells]
        parts = [re.compile(pattern) for pattern in self.clock_text]

        def hidden(place: str, text: str) -> str:
            if any(pattern.search(place) for pattern in whole):
                return CLOCK
            for pattern in parts:
                text = pattern.sub(CLOCK, text)
            return text

        return hidden

    def page(self, work: Path) -> Page:
        """The facts of the page in a work folder."""
        if not self.report:
            return Page()
        text = (work / self.report).read_text()
        for folder, name in ((work, "{work}"), (ROOT, "{root}")):
            text = text.replace(str(folder), name)
        return self.without_clocks(read_page(text))

    def without_clocks(self, page: Page) -> Page:
        """The page without what clocks decide."""
        left = masked(page, self.mask())
        left.sentences = [
            (heading, said)
            for heading, said in left.sentences
            if not any(re.search(pattern, said) for pattern in self.dropped)
        ]
        return left

    def make(self, work: Path) -> float:
        """Run the commands in an empty folder.

        Returns:
            The CPU seconds of all of them.

        Raises:
            RunError: one ended otherwise than it should.
        """
        shutil.copytree(HERE / "inputs", work / "in", dirs_exist_ok=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        for line in self.run:
            words, _, kept = line.format(root=ROOT).partition(" > ")
            done = subprocess.run(
                [str(Path(sys.executable).with_name("steadyload")), *shlex.split(words)],
                cwd=work, env=os.environ | _ONE_THREAD, capture_output=True, text=True,
            )  # fmt: skip
            if done.returncode not in self.status:
                raise RunError(f"steadyload {words}: status {done.returncode}\n{done.stderr}")
            if kept:
                file = work / kept.strip()
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(done.stdout)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def definitions() -> dict[str, Definition]:
    """All pages by name."""
    content = tomllib.loads((HERE / "pages.toml").read_text())
    shared = content.pop("every")
    return {
        name: Definition(
            name,
            **{
                key: tuple(value) if isinstance(value, list) else value
                for key, value in table.items()
                if key not in shared
            },
            **{key: (*shared[key], *table.get(key, ())) for key in shared},
        )
        for name, table in content.items()
    }
