"""Tests of tasks and their rules.

`made_traces`, runs that nothing was simulated for, is a module beside.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
