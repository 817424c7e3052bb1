"""``steadyload view``: watch a loading in the browser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.app.check_defaults import default_help
from steadyload.cli.flags import UsageError
from steadyload.cli.reading import SOME_REFUSED, ReadingFlags, check_output, say_refused
from steadyload.cli.terminal import study_progress
from steadyload.config import REQUIRED, number_from_zero, operand, option, output_option

_RIDDEN = "label@mujoco"
"""The simulation that a load rides in unless another is named."""


@dataclass(frozen=True, kw_only=True)
class View(ReadingFlags):
    """Layouts, and the methods that judge them."""

    file: Path = operand(REQUIRED, "layouts; - reads standard input", metavar="FILE")
    layouts: tuple[str, ...] = option(
        (), "only this one of a file of several; may be repeated", names=("--layout",),
        metavar="NAME",
    )  # fmt: skip
    method: str | None = option(
        None, f"{default_help()}; for --transport {_RIDDEN}",
        names=("--method", "-m"), metavar="SPEC",
    )  # fmt: skip
    beside: str | None = option(None, "another method, played side by side", metavar="SPEC")
    transport: str | None = option(
        None, "play what the complete load does under this rule of the road: en12195, eumos40509, "
        "tilt, or a TOML file", metavar="RULE",
    )  # fmt: skip
    direction: float | None = option(
        None, "of the force on the boxes, one of the rule's (default: 0, forwards)",
        metavar="DEGREES", read=number_from_zero,
    )  # fmt: skip
    output: Path = output_option(Path("view.html"), "the page (default: view.html)")

    def __post_init__(self) -> None:
        if self.direction is not None and self.transport is None:
            raise UsageError("--direction: allowed with --transport alone")

    def run(self) -> int:
        """Write the page; the exit status tells whether some layouts were refused."""
        from steadyload.app.viewing import (
            Recorder,
            pick_layouts,
            riding,
            write_view,
            write_views,
        )
        from steadyload.layouts.files.record import Refused
        from steadyload.layouts.files.refusals import Refusals
        from steadyload.layouts.model.frame import Frame
        from steadyload.layouts.model.layout import Layout
        from steadyload.methods.session.recording import record_loading

        check_output(self.output, [self.file])
        record: Recorder = record_loading
        method = self.method
        if self.transport is not None:
            record = riding(self.transport, self.direction or 0.0)
            method = _RIDDEN if method is None else method
        reading = self.reading()
        frame = Frame.of(reading["dialect"])
        entries = pick_layouts(self.file, self.layouts, **reading)
        methods = [method, *filter(None, [self.beside])]
        refused = Refusals()
        for entry in entries:
            if isinstance(entry, Refused):
                refused.add(str(entry.error))
        with study_progress() as tell:
            if len(entries) == 1 and isinstance(entries[0], Layout):
                tell(f"judging {entries[0].name}")
                page = write_view(entries[0], methods, self.output, record=record, frame=frame)
            else:
                page = write_views(
                    entries, methods, self.output, record=record, frame=frame,
                    progress=tell,
                )  # fmt: skip
            print(page)
        say_refused(refused, len(entries) - refused.count)
        return SOME_REFUSED if refused.count else 0
