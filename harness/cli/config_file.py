"""``--config FILE.toml``: a study's configuration from a file; flags override its keys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from steadyload.config import ConfigError, option, values_of
from steadyload.reading import toml_of

FIELD = "config"
"""The field of a command that names the file."""


def config_option() -> Any:
    """The file from which the other fields are read."""
    return option(
        None, "TOML file whose keys are flags of this command, with underscores; flags override it"
    )


def read_config(path: Path, command: type) -> dict[str, Any]:
    """Values of a configuration file, by field of a command.

    Raises:
        ConfigError: the file is not valid TOML, or has a key or value that is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    return values_of(command, toml_of(path, ConfigError), str(path), apart={FIELD})
