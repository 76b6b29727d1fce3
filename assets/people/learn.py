"""Learn the transport that is shipped from the reaches that are shipped.

``python assets/people/learn.py [FILE]``
"""

import sys
from pathlib import Path

from handsim.learning.transport.recorded import recorded_transport
from handsim.learning.transport.stored import save_transport
from handsim.recordings.folder import read_recordings

HERE = Path(__file__).parent


if __name__ == "__main__":
    learned = recorded_transport(read_recordings(HERE / "pillow"))
    save_transport(learned, Path(sys.argv[1]) if sys.argv[1:] else HERE / "transport.npz")
