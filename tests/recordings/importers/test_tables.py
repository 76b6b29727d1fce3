"""Tables of any locale, names and clocks give the same movement, or are refused in a line."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, JOINT_NAMES
from handsim.recordings.columns.draft import draft_map
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.recording import Recording

USER_FILES = Path(__file__).parents[3] / "../shared/data/user_files"
real_data = pytest.mark.skipif(not USER_FILES.is_dir(), reason="no user files in ../shared")

GERMAN_NAMES = (
    "Daumen_Rotation Daumen_Grundgelenk Daumen_Endgelenk Daumen_Abspreizung "
    "Zeigefinger_Grundgelenk Zeigefinger_Mittelgelenk Zeigefinger_Endgelenk "
    "Mittelfinger_Grundgelenk Mittelfinger_Mittelgelenk Mittelfinger_Endgelenk "
    "Zeigefinger_Abspreizung Ringfinger_Grundgelenk Ringfinger_Mittelgelenk Ringfinger_Endgelenk "
    "Ringfinger_Abspreizung KleinerFinger_Grundgelenk KleinerFinger_Mittelgelenk "
    "KleinerFinger_Endgelenk KleinerFinger_Abspreizung Handwölbung Handgelenk_Beugung "
    "Handgelenk_Deviation"
)
GERMAN = GERMAN_NAMES.split()


def imported(path: Path, **said) -> Recording:
    return import_recordings([path], "table", options=ImportOptions(**said))[0]


def milliseconds(t: float) -> str:
    return f"{1000 * t:.0f}"


def past_midnight(t: float) -> str:
    return (
        "23:59:59," + f"{800 + 1000 * t:03.0f}" if t < 0.2 else f"00:00:00,{1000 * t - 200:03.0f}"
    )


WAYS = {
    "commas": {},
    "tabs": {"sep": "\t"},
    "semicolons": {"sep": ";", "comma": True, "encoding": "cp1252"},
    "german": {"sep": ";", "comma": True, "encoding": "cp1252", "header": ["Zeit [s]", *GERMAN]},
    "utf-16": {"sep": "\t", "encoding": "utf-16"},
    "utf-16 without mark": {"sep": "\t", "encoding": "utf-16-le"},
    "quoted": {"number": '"{:.4f}"'},
    "quoted commas": {"number": '"{:.4f}"', "comma": True},
    "metadata": {"above": ["Subject,3", "Date,2024,5,1", "sep=,", "", "Glove: CyberGlove II"]},
    "numpy": {"header": ["# time", *"abcdefghijklmnopqrstuv"], "sep": " ", "map": True},
    "units": {"sep": ";", "below": [";".join(["s"] + ["deg"] * 22)]},
    "separators at the ends": {"number": "{:.4f}", "ends": True},
    "old mac": {"newline": "\r"},
    "ms": {"header": ["Timestamp", *GERMAN], "stamp": milliseconds},
    "epoch": {"stamp": lambda t: f"{1714550000 + t:.2f}", "header": ["t", *GERMAN]},
    "clock": {"header": ["Uhrzeit", *GERMAN], "stamp": past_midnight, "sep": ";", "comma": True},
    "dates": {
        "header": ["time", *GERMAN],
        "stamp": lambda t: f"01.05.2024 12:30:{1 + t:06.3f}",
    },
    "iso": {
        "header": ["time", *GERMAN],
        "stamp": lambda t: f'"2024-05-01T12:30:{1 + t:09.6f}+02:00"',
        "sep": " ",
    },
}


@pytest.mark.parametrize("way", WAYS)
def test_a_movement_is_the_same_however_it_was_written(way: str, movement) -> None:
    said = dict(WAYS[way])
    mapped, ends = said.pop("map", False), said.pop("ends", False)
    path = movement.write(**said)
    if ends:
        head, *rows = path.read_text().splitlines()
        path.write_text("\n".join([head, *(f"{row}," for row in rows)]))
    if mapped:
        lines = "".join(
            f'[[column]]\nname = "{name}"\nsensor = "{letter}"\n'
            for name, letter in zip(JOINT_NAMES, "abcdefghijklmnopqrstuv", strict=True)
        )
        column_map = movement.folder / "map.toml"
        column_map.write_text(f'[time]\ncolumn = "time"\n{lines}')
        recording = imported(path, column_map=column_map)
    else:
        recording = imported(path)
    assert np.abs(np.rad2deg(recording.q) - movement.angles).max() < 6e-5
    assert np.abs(recording.time - movement.time).max() < 1e-6
    assert recording.name == "a"


def test_units_and_columns_in_any_order(movement) -> None:
    turned = list(reversed(movement.names))
    path = movement.write(header=["t", *turned], values=np.deg2rad(movement.angles[:, ::-1]))
    with pytest.raises(FileError, match="unit of the angles is not said"):
        movement.write(values=np.deg2rad(movement.angles) / 10) and imported(path)
    path = movement.write(
        header=["t", *(f"{name}_rad" for name in turned)],
        values=np.deg2rad(movement.angles[:, ::-1]),
        number="{:.8f}",
    )
    assert np.abs(np.rad2deg(imported(path).q) - movement.angles).max() < 1e-5
    assert np.abs(imported(path, units="deg").q).max() < 0.02


def test_a_map_says_sign_offset_scale_constants_and_labels(movement) -> None:
    path = movement.write(header=["n", *(f"c{i}" for i in range(21)), "force"],
                          stamp=lambda t: f"{100 * t:.0f}")  # fmt: skip
    columns = "".join(
        f'[[column]]\nname = "{name}"\nsensor = "c{i}"\n'
        for i, name in enumerate(JOINT_NAMES[1:20], 1)
    )
    column_map = movement.folder / "map.toml"
    column_map.write_text(
        '[time]\ncolumn = "n"\nunit = "frames"\nrate_hz = 50\n'
        '[[column]]\nname = "thumb_rotation"\nsensor = 2\nsign = -1\noffset = 10\nscale = 2\n'
        + columns
        + '[[column]]\nname = "wrist_flexion"\nsensor = "c20"\nunit = "counts"\nscale = 0.5\n'
        '[[column]]\nname = "wrist_deviation"\nconstant = 5\n'
        '[[column]]\nname = "channel:force_n"\nsensor = "force"\nscale = 0.1\n'
        '[recording]\nsubject = "P7"\nobject = "cup"\nside = "left"\nhand_length_m = 0.18\n'
    )
    recording = imported(path, column_map=column_map)
    degrees = np.rad2deg(recording.q)
    assert degrees[0, 0] == pytest.approx(-2 * (1.125 - 10), abs=1e-4)
    assert degrees[0, 20] == pytest.approx(0.5 * 21.125, abs=1e-4)
    assert recording.channels["force_n"] == pytest.approx(0.1 * movement.angles[:, 21], abs=1e-4)
    assert degrees[:, 21] == pytest.approx(5)
    assert recording.time[-1] == pytest.approx(39 / 50)
    assert (recording.subject, recording.object, recording.hand.side) == ("P7", "cup", "left")
    assert recording.hand.length == 0.18
    assert "wrist_deviation taken as constant, 5 deg" in recording.notes
    with pytest.raises(FileError, match=r"column .c1., named by .*, is missing"):
        imported(movement.write("b.csv"), column_map=column_map)
    for wrong, said in (
        ('name = "thumb"', "is no joint"),
        ('name = "index_mcp"\nconstant = 1', "named twice"),
        ('name = "palm"\nsing = 1', "key 'sing'"),
        ('name = "channel:x"\nsensor = 0', "number from 1"),
        ('name = "channel:x"\nsensor = "c1"\nsign = 2', "use 1 or -1"),
        ("name = ", "is no TOML"),
    ):
        broken = movement.folder / "broken.toml"
        broken.write_text(f"{column_map.read_text().split('[recording]')[0]}[[column]]\n{wrong}\n")
        with pytest.raises(FileError, match=said):
            imported(path, column_map=broken)


def test_a_draft_is_a_map(movement) -> None:
    path = movement.write(header=["t", *(f"sensor{i:02d}" for i in range(22))])
    with pytest.raises(FileError, match=r"handsim recordings map .*a\.csv -o a\.toml"):
        imported(path)
    column_map = movement.folder / "a.toml"
    column_map.write_text(draft_map(path))
    assert "# likeness 0.60, check it" in column_map.read_text()
    q = imported(path, column_map=column_map).q
    assert np.abs(np.rad2deg(q) - movement.angles).max() < 6e-5


def test_a_draft_leaves_out_what_is_like_nothing(movement) -> None:
    names = ["Thumb_CMC_Spread", "Thumb_CMC_Flex", "Thumb_MCP_Flex", "Thumb_IP_Flex"]
    for finger in ("Index", "Middle", "Ring", "Pinky"):
        names += [f"{finger}_{joint}" for joint in ("MCP_Spread", "MCP_Flex", "PIP_Flex")]
    path = movement.write(header=["time", *names], values=movement.angles[:, : len(names)])
    text = draft_map(path)
    assert '# name = "palm_arch"\n# constant = 0.0' in text
    assert '# name = "channel:..."\n# sensor = "Middle_MCP_Spread"' in text
    assert "# index_dip: no column; filled as 0.67 times index_pip" in text
    assert '[[column]]\nname = "thumb_rotation"\nsensor = "Thumb_CMC_Flex"  # likeness 0.70' in text
    column_map = movement.folder / "a.toml"
    column_map.write_text(text)
    with pytest.raises(FileError, match="no column for palm_arch, wrist_flexion, wrist_deviation"):
        imported(path, column_map=column_map)
    for joint in ("palm_arch", "wrist_flexion", "wrist_deviation"):
        text = text.replace(
            f'# [[column]]\n# name = "{joint}"\n# constant = 0.0',
            f'[[column]]\nname = "{joint}"\nconstant = 0.0',
        )
    column_map.write_text(text)
    recording = imported(path, column_map=column_map)
    degrees = np.rad2deg(recording.q)
    pip = degrees[:, JOINT_INDEX["ring_pip"]]
    assert pip == pytest.approx(movement.angles[:, names.index("Ring_PIP_Flex")], abs=6e-5)
    assert degrees[:, JOINT_INDEX["ring_dip"]] == pytest.approx(0.67 * pip)


def test_gaps_doubles_jumps_and_steps_back(movement) -> None:
    values = movement.angles.copy()
    values[10:13, 4] = np.nan
    path = movement.write(values=values)
    with pytest.raises(FileError, match=r"row 12, column IndexMPJ: 'nan' .* gap of 0\.04 s"):
        imported(path)
    with pytest.raises(FileError, match="row 12"):
        imported(path, bridge_s=0.03)
    recording = imported(path, bridge_s=0.05)
    assert recording.notes[-1] == "bridged 3 frames of index_mcp"
    assert np.abs(np.rad2deg(recording.q) - movement.angles).max() < 0.02

    twice = imported(movement.write(stamp=lambda t: f"{t - 0.01 * (t == 0.2):.2f}"))
    assert "1 of 40 frames left out, which repeat the time before them" in twice.notes
    assert len(twice.time) == 39

    with pytest.raises(FileError, match=r"row 22, column time_s: 0\.1 s follows 0\.19 s"):
        imported(movement.write(stamp=lambda t: f"{t - 0.1 * (t == 0.2):.2f}"))

    values = movement.angles.copy()
    values[20:, 20] += 360
    path = movement.write(values=values)
    with pytest.raises(FileError, match="180 deg"):
        imported(path)
    recording = imported(path, unwrap=True)
    assert "jumps of 360 deg taken out of wrist_flexion (20 frames)" in recording.notes
    assert np.abs(np.rad2deg(recording.q) - movement.angles).max() < 6e-5


def test_rates_are_asked_for(movement) -> None:
    path = movement.write(header=["Frame", *movement.names], stamp=milliseconds)
    with pytest.raises(InputError, match="--rate"):
        imported(path)
    assert imported(path, rate_hz=1000).duration == pytest.approx(0.39)
    path = movement.write(header=movement.names, stamp=None)
    with pytest.raises(InputError, match="no column of time"):
        imported(path)
    assert imported(path, rate_hz=200).duration == pytest.approx(39 / 200)


def test_two_hands_and_left_hands(movement) -> None:
    header = ["t", *(f"L_{name}" for name in movement.names), *(f"R_{n}" for n in movement.names)]
    path = movement.write(header=header, values=np.hstack([movement.angles + 1, movement.angles]))
    with pytest.raises(FileError, match="two hands"):
        imported(path)
    left, right = imported(path, side="left"), imported(path, side="right")
    assert 'side = "left"' in draft_map(path, "left")
    assert np.rad2deg(left.q - right.q) == pytest.approx(1, abs=2e-4)
    assert (left.hand.side, right.hand.side) == ("left", "right")

    mirrored = movement.angles.copy()
    mirrored[:, [3, 10, 14, 18, 21]] *= -1
    recording = imported(movement.write(values=mirrored), side="left")
    assert np.abs(np.rad2deg(recording.q) - movement.angles).max() < 6e-5
    assert "left hand in the signs of a right glove" in recording.notes[-1]


def test_labels_come_from_experiments(movement) -> None:
    movement.write("a.csv")
    movement.write("b.txt", sep="\t")
    (movement.folder / "experiments.csv").write_text(
        "file,number,subject,object,task,side,weather\n"
        "b.txt,7,P2,mug,mug-drink,left,rain\na.csv,3,P1,cup,cup-drink,,sun\n"
    )
    for files in ([movement.folder], [movement.folder / "experiments.csv"]):
        both = import_recordings(files, "table")
        assert [(r.name, r.number, r.subject, r.object, r.hand.side) for r in both] == [
            ("b", 7, "P2", "mug", "left"),
            ("a", 3, "P1", "cup", "right"),
        ]
        assert both[0].extra == {"weather": "rain"}
    one = import_recordings(
        [movement.folder / "a.csv"],
        "table",
        options=ImportOptions(task="own", subject=9, object="jar"),
    )
    assert (one[0].object, one[0].task, one[0].subject) == ("jar", "own", "9")


def test_bad_tables_are_refused_in_a_line(movement) -> None:
    for said, match in (
        ({"comma": True}, "row 2 has 45 values for 23 columns; separate cells by semicolons"),
        ({"header": None}, "has no header"),
        ({"header": ["t", *movement.names[:-1], "what"]}, "no column for wrist_deviation"),
        ({"header": ["t", *movement.names[:-1], "PalmArch"]}, "palm_arch may be"),
        ({"header": ["t", *movement.names[:-1], "wrist extension ab"]}, "sign of wrist extension"),
        ({"stamp": lambda t: "soon" if t == 0.2 else f"{t:.2f}"}, "row 22, column time_s: 'soon'"),
        ({"values": np.round(movement.angles + 50), "number": "{:.0f}"}, "--units deg, rad or co"),
    ):
        with pytest.raises(FileError, match=match) as error:
            imported(movement.write(**said))
        assert "\n" not in str(error.value)
    counts = movement.write(values=np.round(movement.angles + 50), number="{:.0f}")
    with pytest.raises(InputError, match="counts from 51 to 94; calibrate the glove"):
        imported(counts, units="counts")


@real_data
@pytest.mark.real_data
@pytest.mark.parametrize(
    "folder",
    ["semicolon-comma", "tab", "unit-row", "comment-header", "eighteen-sensors", "blank-lines",
     "nan-gap", "index-extra-column"],
)  # fmt: skip
def test_user_files_hold_one_movement(folder: str) -> None:
    recording = imported(USER_FILES / folder, bridge_s=0.06)
    first = [9.2332, 9.0364, 8.7692, 6.8229, 11.9766, 11.8390]
    assert np.rad2deg(recording.q[0, :6]) == pytest.approx(first, abs=1e-4)
    assert recording.duration == pytest.approx(1.2)


def test_messages_quote_in_brief(movement) -> None:
    long = movement.write(stamp=lambda t: "x" * 5000 if t == 0.2 else f"{t:.2f}")
    with pytest.raises(FileError, match=r"'x{37}\.\.\.' is no time"):
        imported(long)
    values = np.hstack([movement.angles, movement.angles[:, :1]])
    wide = movement.write(header=["t", *movement.names, "y" * 5000], values=values)
    assert imported(wide).notes[-1] == f"columns ignored: {'y' * 37}..."


def test_an_index_whose_second_row_is_mostly_empty_is_read(movement) -> None:
    """Numbers and empty cells do not make it the first row of a table of numbers."""
    movement.write("a.csv")
    (movement.folder / "experiments.csv").write_text(
        "file,number,subject,object,task,hand_length_m,hand_breadth_m,side,session,notes,lab,day\n"
        "a.csv,1,P7,cup,cup-drink,0.18,0.08,right,monday,good,x,1st\n"
        "b.csv,2,P7,cup,,0.18,0.08,,,,,\n"
    )
    movement.write("b.csv")
    read = import_recordings([movement.folder], "table")
    assert [r.name for r in read] == ["a", "b"]
    assert (read[0].subject, read[0].object, read[0].hand.length) == ("P7", "cup", 0.18)
