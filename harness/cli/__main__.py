"""``python -m steadyload.cli``: the command without its script."""

import sys

from steadyload.cli import main

if __name__ == "__main__":
    sys.exit(main())
