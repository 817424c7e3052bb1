"""``steadyload methods`` and ``steadyload engines``: lists of methods and engines."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.cli.terminal import print_table
from steadyload.config import operand, option


@dataclass(frozen=True)
class Methods:
    """All methods, or one of them."""

    name: str | None = operand(
        None,
        "which one is explained, such as sme or label@mujoco:shrink=0.02 (default: all)",
        metavar="NAME",
    )

    def run(self) -> None:
        """Print a table of methods, or of the parameters of one."""
        from steadyload.errors import nearest
        from steadyload.escaping import shown
        from steadyload.methods.contract.spec import SpecError, parse_spec
        from steadyload.methods.registry import make_method, method_listing, method_parameters

        spec = None if self.name is None else parse_spec(self.name)
        listing = method_listing(spec.engine if spec else None)
        if spec is None:
            print_table(
                ("name", "needs an engine", "what it is"),
                [(m.name, "yes" if m.needs_engine else "no", m.about) for m in listing],
            )
            return
        found = {m.name: m for m in listing}.get(spec.name)
        if found is None:
            known = nearest(spec.name, [m.name for m in listing])
            raise SpecError(f"unknown method {shown(spec.name)}; {known}")
        parameters = found.parameters
        if spec.values:
            parameters = method_parameters(make_method(spec))
        print(f"{found.name}: {found.about}\n")
        print_table(
            ("parameter", "value", "unit", "allowed", "what it is"),
            [(p.name, p.value, p.unit, p.allowed, p.about) for p in parameters],
        )


@dataclass(frozen=True)
class Engines:
    """Settings that engines honour, emulate or ignore."""

    markdown: bool = option(False, "print a Markdown page")

    def run(self) -> None:
        """Print engines and settings."""
        from steadyload.studies.engines.settings_page import (
            engine_records,
            engines_markdown,
            engines_rows,
        )

        records = engine_records()
        if self.markdown:
            print(engines_markdown(records))
            return
        header, rows = engines_rows(records)
        print_table(header, rows)
        print("\nNotes: steadyload engines --markdown")
        for record in records:
            if not record.answers:
                print(record.notes)
