"""The modules beside the tests: ``record.py`` uses them as a script, too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
