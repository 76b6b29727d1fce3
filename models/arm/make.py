"""Make what lies in this folder: both arms of a man of median size, keyframes and scenes.

``python models/arm/make.py`` writes ``right_arm.xml`` and ``left_arm.xml``, what belongs to either,
and a scene of both.
"""

from pathlib import Path

from handsim.arm.arm_file import BESIDE, SURROUNDINGS, keyframes_of, write_arm, write_trunk
from handsim.hand.scene_files import write_both
from handsim.types import SIDES, HandSize


def main(folder: Path = Path(__file__).parent) -> None:
    """Write both arms, what shows them, and the chest that is between them."""
    sizes = {side: HandSize(side=side) for side in SIDES}
    for size in sizes.values():
        write_arm(size, folder)
    write_trunk(sizes["right"], folder)
    apart = {side: keyframes_of(size, BESIDE) for side, size in sizes.items()}
    write_both(folder, SURROUNDINGS, apart)


if __name__ == "__main__":
    main()
