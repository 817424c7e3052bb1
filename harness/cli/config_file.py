"""``--config FILE.toml``: a study's configuration from a file; flags override its keys."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from steadyload.errors import UserError, nearest
from steadyload.studies.options import option

FIELD = "config"
"""The field of a command that names the file."""


class ConfigFileError(UserError):
    """A file of a configuration that cannot be read, or holds what is not allowed."""


def config_option() -> Any:
    """The file from which the other fields are read."""
    return option(
        None, "TOML file whose keys are flags of this command, with underscores; flags override it"
    )


def read_config(path: Path, keys: Collection[str]) -> Mapping[str, Any]:
    """Values of a configuration file, by key.

    Raises:
        ConfigFileError: it is no TOML, or has a key that is none.
        OSError: it cannot be read.
    """
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ConfigFileError(f"{path}: {error}") from None
    for key in found:
        if key not in keys:
            raise ConfigFileError(f"{path}: unknown key {key!r}; {nearest(key, keys)}")
    return found
