"""The modules beside the tests: ``record.py`` uses them as a script, too."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "perturbing")]
