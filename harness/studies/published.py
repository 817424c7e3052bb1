"""Published pages: their folders and commands, and the index of all."""

from __future__ import annotations

import glob
import html
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urljoin

from steadyload.atomic import write_atomically
from steadyload.errors import UserError, nearest
from steadyload.reading import MAX_STORED_BYTES, content_of
from steadyload.studies.kit import PublishedPage
from steadyload.studies.registry import studies, study

FOLDER = Path("reports/published")
"""Folder of the pages, below the repository's root."""

ROWS = Path("reports/rows")
"""Folder of the packed rows that pages are made of, below the repository's root."""

INDEX = "README.md"

THUMBNAIL_WIDTH = 240
"""Width of the figures in the index, in pixels."""

_TIME = re.compile(r"\d\]? (?:us|ms|s)\b")


class UnknownPageError(UserError):
    """No published page has this name."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A published page.

    Attributes:
        name: its folder.
        answers: the sentence that it answers.
        command: words of the command that makes it, without the output folder.
        work: folder of the rows that it is made of.
        verdicts: see :attr:`steadyload.studies.kit.Study.verdicts`.
    """

    name: str
    answers: str
    command: tuple[str, ...]
    work: Path
    verdicts: bool = False

    def text(self, folder: Path) -> str:
        """Text of the existing page; empty where there is none yet."""
        path = folder / self.name / "report.md"
        return content_of(path, MAX_STORED_BYTES).decode() if path.exists() else ""


def entries() -> list[Entry]:
    """All published pages, in the order of the registry."""
    return [
        Entry(
            page.folder,
            page.answers or one.answers,
            (*one.command_words.split(), *shlex.split(page.flags)),
            _work(page, one.work),
            one.verdicts,
        )
        for one in map(study, studies())
        for page in one.pages
    ]


def _work(page: PublishedPage, usual: Path) -> Path:
    words = shlex.split(page.flags)
    return Path(words[words.index("--work") + 1]) if "--work" in words else usual


def named(names: tuple[str, ...]) -> list[Entry]:
    """The pages with some names; all where no names are given.

    Raises:
        UnknownPageError: no page has one of the names.
    """
    known = {entry.name: entry for entry in entries()}
    for name in names:
        if name not in known:
            raise UnknownPageError(f"unknown page {name!r}; {nearest(name, known)}")
    return [known[name] for name in names] or list(known.values())


def remaking(entry: Entry, folder: Path) -> list[str]:
    """Words of the command that remakes a page."""
    return [*_filled(entry.command), "--output", str(folder / entry.name)]


def _filled(words: tuple[str, ...]) -> Iterator[str]:
    """Words with file patterns replaced by the files there are; without any, as in a shell, the
    pattern stays, for the command to refuse.
    """
    for word in words:
        yield from sorted(glob.glob(word)) or [word]


def index(folder: Path) -> str:
    """The index of the pages of a folder, in Markdown, with the leading figure of each."""
    lines = ["# Published pages", "", "Each begins with its answer; `make pages` remakes them."]
    for entry in entries():
        text = entry.text(folder)
        if text:
            link = f"{entry.name}/report.md"
            lines += ["", f"## [{title(text)}]({link})", ""]
            shown = figure(text)
            if shown:
                lines += [f"[{_thumbnail(f'{entry.name}/{shown}', title(text))}]({link})"]
            said = _from_the_index(listed_answer(text), entry.name)
            lines += [" ".join(filter(None, (f"**{entry.answers}**", said)))]
            lines += ["", '<br clear="left">'] if shown else []
    return "\n".join(lines) + "\n"


def _from_the_index(text: str, name: str) -> str:
    """A text of a page with its links as they lead from the folder above."""
    page = f"{name}/report.md"
    return re.sub(r"\]\(([^()]+)\)", lambda found: f"]({urljoin(page, found[1])})", text)


def _thumbnail(path: str, alternative: str) -> str:
    """A small picture that the text after it flows around."""
    alt = html.escape(alternative)
    return f'<img src="{path}" width="{THUMBNAIL_WIDTH}" align="left" hspace="12" alt="{alt}">'


def write_index(folder: Path) -> Path:
    """Write the index beside the pages; returns its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / INDEX
    write_atomically(path, index(folder).encode())
    return path


def title(text: str) -> str:
    """The title of a page."""
    return text.partition("\n")[0].removeprefix("# ").strip()


def figure(text: str) -> str:
    """Path of the first figure of a page, from the page; empty where it has none."""
    found = re.search(r"^!\[.*\]\(([^)]+)\)$", text, re.MULTILINE)
    return found[1] if found else ""


def listed_answer(text: str) -> str:
    """The answer of a page as the index lists it: one with times of a busy machine is refused."""
    from steadyload.runs.costs import MARK

    found = answer(text)
    if MARK in text and _TIME.search(found):
        return "(Times were taken on a busy machine: the page has the answer.)"
    return found


def answer(text: str) -> str:
    """The first paragraph of a page; empty where it begins with anything else."""
    parts = [part.strip() for part in text.partition("\n")[2].split("\n\n")]
    first = next((part for part in parts if part), "")
    return "" if first.startswith(("#", "|", "- ", "!", "```")) else " ".join(first.split())
