"""How results are laid out."""

from handsim.cli.console import say_table


def test_columns_stand_below_each_other_whatever_the_letters(capsys):
    say_table(
        ("recording", "frames", "by"), [("a", 12, ""), ("コップ", 3, "x"), ("long-name-1", 4, "")]
    )
    assert capsys.readouterr().out.splitlines() == [
        "recording    frames  by",
        "a                12",
        "コップ            3   x",
        "long-name-1       4",
    ]


def test_a_table_without_rows_is_its_header(capsys):
    say_table(("joint", "frames"), [])
    assert capsys.readouterr().out == "joint  frames\n"
