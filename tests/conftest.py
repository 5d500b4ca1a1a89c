"""Makes the helpers of this folder importable from every test, from a checkout and against an installed package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
