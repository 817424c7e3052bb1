"""``python -m steadyload.cli``: the command without its script."""

import sys

from steadyload.cli import command

if __name__ == "__main__":
    sys.exit(command())
