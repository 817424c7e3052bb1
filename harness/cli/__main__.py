"""``python -m harness.cli``: the command without its script."""

import sys

from harness.cli import main

if __name__ == "__main__":
    sys.exit(main())
