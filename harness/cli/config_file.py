"""``--config FILE.toml``: a study's configuration from a file; flags override its keys."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from steadyload.config import option
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown
from steadyload.reading import toml_of

FIELD = "config"
"""The field of a command that names the file."""


class ConfigFileError(UserError):
    """A configuration file that cannot be read, or holds a key or value that is not allowed."""


def config_option() -> Any:
    """The file from which the other fields are read."""
    return option(
        None, "TOML file whose keys are flags of this command, with underscores; flags override it"
    )


def read_config(path: Path, keys: Collection[str]) -> Mapping[str, Any]:
    """Values of a configuration file, by key.

    Raises:
        ConfigFileError: the file is not valid TOML, or has an unknown key.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    found = toml_of(path, ConfigFileError)
    for key in found:
        if key not in keys:
            raise ConfigFileError(f"{path}: unknown key {shown(key)}; {nearest(key, keys)}")
    return found
