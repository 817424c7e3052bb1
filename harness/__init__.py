"""steadyload: how stable is a pallet while it is being loaded?

Data flows one way: layouts -> methods -> runs -> studies -> pages. What is named here is the public
interface; each name is imported when it is first asked for, so that ``import steadyload`` itself
costs nothing.

Example:
    >>> import steadyload as sl
    >>> item = sl.Item(0, position=(0, 0, 0), size=(40, 30, 40), weight=12)
    >>> layout = sl.Layout("one", sl.Pallet(120, 160, 80), (item,))
    >>> sl.make_method("sme").judge(layout).score
    1.0
"""

from __future__ import annotations

if __name__ != "steadyload":
    raise ImportError("harness is installed as steadyload: import it under that name")

TYPE_CHECKING = False  # that of typing: nothing is imported, see steadyload.cli.interrupts
if TYPE_CHECKING:
    from steadyload.app.checking import check as check
    from steadyload.app.repairs import repair as repair
    from steadyload.app.viewing import write_view as view
    from steadyload.layouts.batch_files import read_batch as read_batch
    from steadyload.layouts.benchmark import load_benchmark as load_benchmark
    from steadyload.layouts.files.dialect import Dialect as Dialect
    from steadyload.layouts.files.dialect import load_profile as load_profile
    from steadyload.layouts.formats import read_layouts as read
    from steadyload.layouts.model.batch import LayoutBatch as LayoutBatch
    from steadyload.layouts.model.layout import Item as Item
    from steadyload.layouts.model.layout import Layout as Layout
    from steadyload.layouts.model.layout import Pallet as Pallet
    from steadyload.layouts.packers.with_packingsolver import (
        from_packingsolver as from_packingsolver,
    )
    from steadyload.layouts.packers.with_packvium import from_packvium as from_packvium
    from steadyload.layouts.packers.with_py3dbp import from_py3dbp as from_py3dbp
    from steadyload.methods.contract.method import Verdict as Verdict
    from steadyload.methods.registry import make_method as make_method
    from steadyload.methods.session.session import LoadingSession as LoadingSession
    from steadyload.runs.results import load_results as load_results
    from steadyload.runs.scoring import score_layouts as score
    from steadyload.studies.kept_rows import rows as rows

    __version__: str

_PUBLIC = {
    "Dialect": "steadyload.layouts.files.dialect:Dialect",
    "Item": "steadyload.layouts.model.layout:Item",
    "Layout": "steadyload.layouts.model.layout:Layout",
    "LayoutBatch": "steadyload.layouts.model.batch:LayoutBatch",
    "LoadingSession": "steadyload.methods.session.session:LoadingSession",
    "Pallet": "steadyload.layouts.model.layout:Pallet",
    "Verdict": "steadyload.methods.contract.method:Verdict",
    "check": "steadyload.app.checking:check",
    "from_packingsolver": "steadyload.layouts.packers.with_packingsolver:from_packingsolver",
    "from_packvium": "steadyload.layouts.packers.with_packvium:from_packvium",
    "from_py3dbp": "steadyload.layouts.packers.with_py3dbp:from_py3dbp",
    "load_benchmark": "steadyload.layouts.benchmark:load_benchmark",
    "load_profile": "steadyload.layouts.files.dialect:load_profile",
    "load_results": "steadyload.runs.results:load_results",
    "make_method": "steadyload.methods.registry:make_method",
    "read": "steadyload.layouts.formats:read_layouts",
    "read_batch": "steadyload.layouts.batch_files:read_batch",
    "repair": "steadyload.app.repairs:repair",
    "rows": "steadyload.studies.kept_rows:rows",
    "score": "steadyload.runs.scoring:score_layouts",
    "view": "steadyload.app.viewing:write_view",
}
"""Public name -> ``"module:name"`` of what it stands for."""

__all__ = [
    "Dialect",
    "Item",
    "Layout",
    "LayoutBatch",
    "LoadingSession",
    "Pallet",
    "Verdict",
    "check",
    "from_packingsolver",
    "from_packvium",
    "from_py3dbp",
    "load_benchmark",
    "load_profile",
    "load_results",
    "make_method",
    "read",
    "read_batch",
    "repair",
    "rows",
    "score",
    "view",
]


if not TYPE_CHECKING:  # for which a name that is not declared above is a mistake

    def __getattr__(name: str) -> object:
        if name == "__version__":
            from importlib.metadata import version

            return version("steadyload")
        if name not in _PUBLIC:
            raise AttributeError(f"module 'steadyload' has no attribute {name!r}")
        import importlib

        module, _, attribute = _PUBLIC[name].partition(":")
        found = getattr(importlib.import_module(module), attribute)
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
