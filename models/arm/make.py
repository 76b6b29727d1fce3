"""Make what lies in this folder: ``right_arm.xml`` and ``left_arm.xml``, of a man of median size.

``python models/arm/make.py`` writes them.
"""

from pathlib import Path

from handsim.arm.arm_file import write_arm
from handsim.types import SIDES, HandSize


def main(folder: Path = Path(__file__).parent) -> None:
    """Write both arms."""
    for side in SIDES:
        write_arm(HandSize(side=side), folder)


if __name__ == "__main__":
    main()
