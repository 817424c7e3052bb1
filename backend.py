"""How ``pip`` builds this package: by setuptools, with a C compiler from the Python package index
where this machine has none. As a program it ends with status 1 there, and with 0 elsewhere.
"""

import importlib.util
import sys
import tomllib
from pathlib import Path

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403 - the other hooks of PEP 517


def building():
    """The module that builds the C library, of a package that is not installed yet."""
    spec = importlib.util.spec_from_file_location("building", "harness/core/building.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def get_requires_for_build_wheel(config_settings=None):
    """The requirements of setuptools, and a compiler."""
    return build_meta.get_requires_for_build_wheel(config_settings) + _compiler()


def get_requires_for_build_editable(config_settings=None):
    """The requirements of setuptools, and a compiler."""
    return build_meta.get_requires_for_build_editable(config_settings) + _compiler()


def _compiler():
    """The package with a compiler, where there is no other."""
    if building().found():
        return []
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
    return project["dependency-groups"]["compiler"]


if __name__ == "__main__":
    sys.exit(bool(_compiler()))
