"""The module beside the tests: vertical balance that compiled code is held against."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
