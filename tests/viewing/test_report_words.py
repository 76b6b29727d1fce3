"""What the report says in words of a controller, without making the page."""

from handsim.learning.guide.choice import LeftOut
from handsim.learning.guide.predictor import GuideSettings
from handsim.viewing.report import what_leads


def test_what_a_movement_follows_is_said_with_the_reason_for_progress() -> None:
    compared = LeftOut(with_progress=0.5934, without_progress=0.6091)
    by_progress = what_leads(GuideSettings(progress=True), compared)
    assert "Progress along it is a coordinate" in by_progress
    assert "off by 0.593 of a straight line's error with" in by_progress
    assert "by 0.609 without" in by_progress
    by_place = what_leads(GuideSettings(progress=False), None)
    assert "progress is no coordinate" in by_place and "left out" not in by_place
    assert "no path is predicted" in what_leads(None, None)
