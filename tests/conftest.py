"""Makes the helpers of this folder importable from every test, from a checkout and against an installed package."""

import sys
from pathlib import Path

from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))
settings.register_profile("ropeway", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("ropeway")
