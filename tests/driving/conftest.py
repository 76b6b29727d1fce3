"""Tests of driving.

`made_up`, demonstrations with signals that no controller is learned from, is a module beside.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
