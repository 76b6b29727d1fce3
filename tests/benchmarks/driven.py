"""How near a hand comes to the person's that their own signal drives, each recording left out.

    python tests/benchmarks/driven.py [FOLDER ...] [--channel NAME]

Without folders: the reaches for a pillow that are shipped, and the doors of ../shared where they
are. Controller and map of the signal are learned from the others.
"""

import argparse
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import handsim
from handsim.driving.driver import DriverRule
from handsim.driving.replay import Driven, drive_postures
from handsim.driving.signal_calibration import calibrate_signal
from handsim.recordings.plausibility import PlausibilityWarning
from handsim.recordings.signals import DISTANCE, signals_of

DOOR = Path(__file__).parents[2] / "../shared/data/door_teleop/door.npz"


def pillow() -> handsim.RecordingSet:
    """The reaches of a person for a pillow that are shipped."""
    return handsim.read_recordings(handsim.data_folder("assets") / "people" / "pillow")


def door() -> handsim.RecordingSet:
    """The reaches of a person for a handle; cut where the latch first moves."""
    whole = handsim.import_recordings([DOOR], "adroit")
    return handsim.cut_recordings(whole, handsim.CutOptions(channel="latch_rad")).recordings


def left_out(recordings: handsim.RecordingSet, channel: str, places: Iterable[int]) -> list[Driven]:
    """Drive some recordings by a channel, with what was learned from all the others."""
    results = []
    for i in places:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PlausibilityWarning)
            controller = handsim.learn_controller(recordings.without(i)).controller
        rule = DriverRule(calibrate_signal(controller.demonstrations, channel))
        one = recordings[i]
        values = signals_of(one.time, one.channels)[channel]
        results.append(
            drive_postures(
                controller, rule, one.time, values, one.q[0], one.q[-1], one.q, one.object
            )
        )
    return results


def means(results: list[Driven]) -> tuple[float, float, float]:
    """Mean rms of driven postures and of the time law [deg], and their ratio."""
    driven = float(np.mean([each.rms_deg for each in results]))
    law = float(np.mean([each.time_law_rms_deg for each in results]))
    return driven, law, driven / law


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--channel", default=DISTANCE)
    asked = parser.parse_args()
    sets = {str(folder): handsim.read_recordings(folder) for folder in asked.folders}
    if not sets:
        sets = {"pillow": pillow()} | ({"door": door()} if DOOR.is_file() else {})
    for name, recordings in sets.items():
        driven, law, ratio = means(left_out(recordings, asked.channel, range(len(recordings))))
        sys.stdout.write(
            f"{name}: {len(recordings)} left out, driven {driven:.2f} deg, time law {law:.2f} deg, "
            f"ratio {ratio:.2f}\n"
        )


if __name__ == "__main__":
    main()
