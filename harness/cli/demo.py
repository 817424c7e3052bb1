"""``steadyload demo``: what ``steadyload check`` says of the package's own pallets."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.check import Check
from steadyload.cli.fail_on import FailOn
from steadyload.cli.flags import UsageError
from steadyload.cli.terminal import say
from steadyload.config import option, output_option


@dataclass(frozen=True, kw_only=True)
class Demo:
    """Where the pallets and their page go."""

    output: Path = output_option(Path("demo"), "folder of the pallets and the page (default: demo)")
    no_open: bool = option(False, "do not open the page in the browser")

    def run(self) -> int:
        """Write the pallets, check them, and open their page where somebody looks."""
        from steadyload.app.checked_page import PAGE
        from steadyload.app.demo import demo_pallets
        from steadyload.atomic import without_link
        from steadyload.layouts.formats import Format, write_layouts
        from steadyload.layouts.writers import as_native
        from steadyload.reading import MAX_STORED_BYTES, content_of

        self.output.mkdir(parents=True, exist_ok=True)
        file, pallets = self.output / "pallets.json", demo_pallets()
        own = "".join(as_native(pallets)).encode()
        if file.exists() and content_of(file, MAX_STORED_BYTES) != own:
            raise UsageError(
                f"--output: {str(file)!r} is not the demo's; allowed: a folder without that file"
            )
        write_layouts(without_link(file), pallets, Format.NATIVE)
        say(f"steadyload check {file} --html {self.output}")
        status = Check(files=(file,), html=self.output, fail_on=FailOn()).run()
        if sys.stdout.isatty() and not self.no_open:
            import webbrowser

            webbrowser.open((self.output / PAGE).resolve().as_uri())
        return status
