import pytest

from handsim.errors import HandsimError
from handsim.types import MEDIAN_HAND, HandSize
from handsim.viewing.live.table_place import TablePlace
from handsim.viewing.live.view_text import PageView, close_to, link_html, read_view, view_text

WHOLE = PageView(
    {"start": "1.00,2.00,3.00", "share": "0.250"},
    HandSize(0.185, 0.080),
    "cup-drink",
    TablePlace(-30, 12, 45),
    2.5,
    False,
    (0.5, 0.5, 0.4, 0.0, -0.02, 0.1),
    ("built-in", "field only"),
)


def test_the_text_of_a_view_brings_it_back_from_wherever_it_is_pasted() -> None:
    text = view_text(WHOLE)
    for given in (text, f"?{text}", f" http://127.0.0.1:8080/?{text}\n"):
        assert read_view(given, WHOLE.shown) == WHOLE


def test_what_is_as_usual_is_left_out() -> None:
    assert view_text(PageView()) == ""
    assert read_view("", ("a",)) == PageView()
    assert view_text(PageView(task="cup-drink")) == "task=cup-drink"
    assert view_text(PageView(loop=True)) == "loop=1"
    assert read_view("loop=1", ("a",)).loop
    assert read_view("task=cup-drink", ("a",)).size == MEDIAN_HAND


def test_a_link_of_other_controllers_says_which() -> None:
    with pytest.raises(HandsimError, match="shows built-in and field only, this page a"):
        read_view(view_text(WHOLE), ("a",))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("colour=red", "'colour' is not part of a view"),
        ("nonsense", "'nonsense' is not part of a view"),
        ("task=cup-drnk", "cup-drink"),
        ("object=1,2", "give -150 to 150, -200 to 200, -90 to 90"),
        ("object=1,2,nan", "object '1,2,nan'"),
        ("object=1,900,0", "object '1,900,0'"),
        ("time=-1", "time '-1'; give 0 to 60"),
        ("hand=10,80", "hand '10,80'; give 150 to 220, 65 to 105"),
        ("camera=1,2,3", "camera"),
        ("loop=yes", "loop 'yes'; give 0 or 1"),
    ],
)
def test_texts_that_are_no_view(text: str, said: str) -> None:
    with pytest.raises(HandsimError, match=said):
        read_view(text, ("a",))


def test_links_are_relative_and_cameras_compared_as_links_tell_them() -> None:
    assert 'href="/?task=cup-drink&amp;time=1.00"' in link_html("task=cup-drink&time=1.00")
    assert close_to(None, None)
    assert close_to((1.0, 2.0), (1.0002, 2.0))
    assert not close_to((1.0, 2.0), (1.1, 2.0))
    assert not close_to(None, (1.0,))
