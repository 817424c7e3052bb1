"""three.js for pages that must open without a network, out of an installed Python package.

The wheel of trimesh (0.7 MB, needs NumPy alone) ships a whole three.js release inside the template
of its own viewer; the rest of that template is left out. Measured against others that ship one,
as gzip in base64, the form in which it stands in a page: trimesh 0.20 MB (r140, every class of
three.js public), pythreejs 0.18 MB (r97, no longer maintained, needs all of IPython), meshcat
0.29 MB (r132, needs a message queue and a tunnel), k3d 1.1 MB (r186, keeps three.js to itself).
"""

from __future__ import annotations

import zipfile
from importlib import metadata

from steadyload.errors import UserError

_ARCHIVE = "trimesh/resources/templates/viewer.zip"
_MEMBER = "viewer.html.template"
_BEGIN, _BODY = "/**\n * @license", "\n!function"


class ThreeJsError(UserError):
    """three.js is not where it should be."""


def three_js() -> str:
    """The source of three.js: run as a classic script it defines the global ``THREE``.

    Raises:
        ThreeJsError: trimesh is not installed, or ships no three.js that can be told apart.
    """
    try:
        package = metadata.distribution("trimesh")
    except metadata.PackageNotFoundError:
        raise ThreeJsError("a view needs the package trimesh: pip install trimesh") from None
    try:
        with zipfile.ZipFile(str(package.locate_file(_ARCHIVE))) as archive:
            page = archive.read(_MEMBER).decode()
        begin = page.index(_BEGIN, page.index("<script>"))
        body = page.index(_BODY, begin) + 1
        library = page[begin : page.index("\n", body)]
    except (OSError, KeyError, ValueError):
        library = ""
    if "Three.js Authors" not in library or "THREE={}" not in library:
        raise ThreeJsError(
            f"trimesh {package.version} ships no three.js as 5.2 does: "
            "pip install 'trimesh>=5.2,<6'"
        )
    return library
