"""Largest sizes that a layout file may have, whatever its format: checked while it is read."""

from __future__ import annotations

MAX_ITEMS = 5_000
"""Items of a layout."""

MAX_LAYOUTS = 1_000_000
"""Layouts of a file."""

MAX_FILE_BYTES = 256 * 1024**2
"""Bytes of a file, of a pipe and of standard input."""

MAX_STREAM_BYTES = 4 * 1024**3
"""Bytes of a file of which one layout, or one row group, at a time is held in memory."""

MAX_GROUP_VALUES = 32 * 1024**2
"""Values of a row group of a Parquet file, those in lists among them."""

MAX_FOOTER_BYTES = 1024**2
"""Bytes of the footer of a Parquet file, which states where each column of each group lies: one of
a million layouts, 10,000 a group, has some 300 KiB."""

MAX_VALUE_LENGTH = 4 * 1024**2
"""Characters of such a layout, before anything is built of them."""

MAX_WAITING = 200_000
"""Layouts and items of a file that are held because what names them may follow."""

MAX_YAML_BYTES = 8 * 1024**2
"""Bytes of a YAML file: its parser takes a second for 4 MB even in C, and the largest real schedule
is below 2 MB."""

MAX_YAML_VALUES = 100_000
"""Texts, numbers, lists and objects of a YAML file: five times those of the largest real schedule,
and a second for its parser."""

MAX_COPIES = 10_000
"""Layouts that a plan may state at once, as copies of a loaded bin."""

MAX_COPIED_ITEMS = 1_000_000
"""Items of all layouts of such a plan, copies included."""

MAX_DEPTH = 32
"""How deep lists and objects may lie in each other."""

MAX_NUMBER_LENGTH = 64
"""Characters of a number; a number of this program has at most 25."""

MAX_TEXT_LENGTH = 1_000
"""Characters of a name, of a column's name, or of any other text of a file."""
