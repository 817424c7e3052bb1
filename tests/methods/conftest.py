"""The module beside the tests: hulls that compiled code is held against."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
