"""Profiles of files of recorded motion: names of columns, what is known of the body, the noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from steadyload.config import bind
from steadyload.measured.errors import MotionError
from steadyload.measured.motion import Trial
from steadyload.measured.motion_files import checked_names, read_motion
from steadyload.measured.releases import Noise
from steadyload.reading import toml_of


@dataclass(frozen=True, kw_only=True)
class MotionProfile:
    """How a file of recorded motion is read, and where it is from.

    Attributes:
        body: what was recorded, in words, such as ``an acrylic cube``.
        source: where the file is from, with its licence.
        columns, constants, ignored: see :func:`steadyload.measured.motion_files.read_motion`.
        noise: of a released state that is measured.
    """

    body: str = ""
    source: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    noise: Noise = field(default_factory=Noise)

    def read(self, path: str | Path) -> tuple[Trial, ...]:
        """All trials of a file: see :func:`steadyload.measured.motion_files.read_motion`."""
        return read_motion(
            path, columns=self.columns, constants=self.constants, ignored=self.ignored
        )


def motion_profile(path: str | Path) -> MotionProfile:
    """The profile that a TOML file states.

    Raises:
        MotionError: not a TOML file, or a key or value of it is not allowed.
        TooLargeError: it has too many bytes.
        OSError: it cannot be read.
    """
    found = bind(MotionProfile, toml_of(Path(path), MotionError), str(path), MotionError)
    try:
        checked_names(found.columns, found.constants)
    except MotionError as error:
        raise MotionError(f"{path}: {error}") from None
    return found
