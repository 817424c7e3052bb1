"""Where the packages of ``steadyload`` lie: every top-level folder is installed below one name.

A wheel has them there. An editable install has links there, in ``.src``, which is one line of a
``.pth`` file: what is imported is what editors and type checkers find.
"""

import atexit
import contextlib
import os
import re
import shutil
import sysconfig
import tempfile
from pathlib import Path

from setuptools import Command, find_packages, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py
from setuptools.command.editable_wheel import editable_wheel

from backend import building

FOLDERS = {
    "steadyload": "harness",
    "steadyload.engines": "engines",
    "steadyload.learners": "learners",
    "steadyload.reports": "reports",
}
SOURCES = ".src"

BUILD = tempfile.mkdtemp(prefix="steadyload-build-")
atexit.register(shutil.rmtree, BUILD, ignore_errors=True)


class Links(Command):
    """Bring the links up to date: one for every folder, and for every child of ``harness``."""

    description = f"link all packages below their import name, in {SOURCES}"
    user_options = []  # noqa: RUF012 - so declared by setuptools

    def initialize_options(self):
        """There are no options."""

    def finalize_options(self):
        """There are no options."""

    def run(self):
        """Leave links that are right alone: another process may be importing through them."""
        package = Path(SOURCES, "steadyload")
        package.mkdir(parents=True, exist_ok=True)
        folders = [*Path("harness").iterdir(), *map(Path, ("engines", "learners", "reports"))]
        wanted = {
            package / folder.name: Path(os.path.relpath(folder, package))
            for folder in folders
            if not folder.name.startswith((".", "__pycache__"))
        }
        for link in package.iterdir():
            if link.is_symlink() and wanted.get(link) != link.readlink():
                link.unlink()
        for link, target in wanted.items():
            if not link.is_symlink():
                link.symlink_to(target)


class Build(build_py):
    """The packages with the C library for this platform: in the clone where that is installed."""

    def run(self):
        """Build the library beside its sources, or beside the copies of these."""
        super().run()
        package = "harness" if self.editable_mode else Path(self.build_lib, "steadyload")
        building().build(Path(package, "core", "lib"), building().name())


class Wheel(bdist_wheel):
    """A wheel for this platform alone, and for every Python."""

    def get_tag(self):
        """The library calls nothing of Python."""
        return "py3", "none", re.sub(r"[-.]", "_", sysconfig.get_platform())


class Editable(editable_wheel):
    """An editable install of the links, or of the mapping where links cannot be made."""

    def finalize_options(self):
        """Say where the packages lie before they are looked for."""
        with contextlib.suppress(OSError):
            self.run_command("links")
            self.distribution.package_dir = {"": SOURCES}
        super().finalize_options()


setup(
    cmdclass={
        "links": Links,
        "build_py": Build,
        "bdist_wheel": Wheel,
        "editable_wheel": Editable,
    },
    packages=[
        ".".join([name, *inner])
        for name, folder in FOLDERS.items()
        for inner in ([], *([package] for package in find_packages(folder)))
    ],
    package_dir=FOLDERS,
    package_data={"": ["**/*"]},
    exclude_package_data={
        "": ["__pycache__/*", "*/__pycache__/*"],
        # Libraries of the clone, which may be of other sources.
        "steadyload": ["core/lib/*"],
        "steadyload.core": ["lib/*"],
        "steadyload.reports": ["published/**", "rows/**"],
    },
    # What an earlier build left beside the sources would add modules that have been deleted since.
    options={"build": {"build_base": BUILD}, "egg_info": {"egg_base": BUILD}},
)
