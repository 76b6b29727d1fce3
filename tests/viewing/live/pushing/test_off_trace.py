import re

import numpy as np
import pytest

from handsim.viewing.live.pushing.off_trace import off_trace, pushed_spans, return_words

TIMES = np.arange(1, 101) / 100


def past(begins: float, ends: float, back: float, now: float = 1.0) -> list:
    """A push of 10 N that takes a hand 5 deg off, which comes back at a time."""
    return [
        (t, np.deg2rad(5.0 if begins <= t < back else 0.0), 10.0 if begins <= t < ends else 0.0)
        for t in TIMES.round(2).tolist()
        if t <= now
    ]


def test_spans_are_from_the_first_to_the_last_push() -> None:
    (span,) = pushed_spans(past(0.2, 0.4, 0.5))
    assert span == pytest.approx((0.2, 0.39))
    assert pushed_spans(past(0.2, 0.4, 0.5, now=0.3)) == [(0.2, 0.3)]
    assert pushed_spans([]) == pushed_spans(past(2, 2, 2)) == []


def test_what_a_push_did_is_said_while_it_lasts_and_once_the_hand_is_back() -> None:
    assert return_words(past(2, 2, 2)) == ""
    assert return_words(past(0.2, 0.4, 0.5, now=0.3)) == "Pushed with 10 N: 5.0 deg off its way."
    assert return_words(past(0.2, 0.4, 2.0)).endswith("off its way, 5.0 deg now.")
    assert return_words(past(0.2, 0.4, 0.5)).endswith("back within 0.5 deg 0.11 s after it ended.")
    assert return_words(past(0.2, 0.4, 0.3)).endswith("back within 0.5 deg 0.01 s after it ended.")


def test_the_picture_shades_pushes_and_draws_a_line_a_hand() -> None:
    picture = off_trace([past(0.2, 0.4, 0.5), past(2, 2, 2)], ["<one>", "two"])
    assert picture.count("<polyline") == 2
    assert picture.count('fill="#e6e8ec"') == 1
    assert "&lt;one&gt;" in picture
    assert ">5.5</text>" in picture, "a tenth above the largest"
    first, second = re.findall(r'points="([^"]*)"', picture)
    height = {float(point.split(",")[1]) for point in first.split()}
    assert min(height) == pytest.approx(70 - 70 / 1.1, abs=0.1)
    assert max(height) == 70
    assert {float(point.split(",")[1]) for point in second.split()} == {70}
    last = first.split()[-1]
    assert float(last.split(",")[0]) == pytest.approx(240)


def test_one_hand_is_not_named_and_nothing_is_drawn_before_the_start() -> None:
    assert off_trace([[]], ["hand"]) == ""
    picture = off_trace([past(2, 2, 2)], ["hand"])
    assert "hand" not in picture
    assert ">2.0</text>" in picture
