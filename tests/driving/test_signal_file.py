"""Files of signals: recordings, tables of time and value, and what is neither."""

from pathlib import Path

import numpy as np
import pytest
from made_up import demonstration, falling

from handsim.driving.signal_file import chosen_channel, read_signal_file
from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import data_folder
from handsim.joints import N_JOINTS
from handsim.recordings.posture_file import postures_text

PILLOW = data_folder("assets") / "people" / "pillow" / "pillow-01.csv"


def table(path: Path, header: str = "time_s,value", rows: int = 12, cell=lambda i: f"{i}") -> Path:
    lines = [header, *(f"{i / 10},{cell(i)}" for i in range(rows))]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_recording_with_channels() -> None:
    read = read_signal_file(PILLOW)
    assert read.q is not None and read.q.shape == (len(read.time), N_JOINTS)
    assert {"distance_m", "palm_x_m", "aperture_m"} <= read.signals.keys()
    assert 0.1 < read.signals["distance_m"][-1] < read.signals["distance_m"][0] < 0.6


def test_a_table_of_time_and_value(tmp_path: Path) -> None:
    read = read_signal_file(table(tmp_path / "s.csv", cell=lambda i: "" if i == 3 else str(2 * i)))
    assert read.q is None
    assert list(read.signals) == ["value"]
    assert np.flatnonzero(np.isnan(read.signals["value"])).tolist() == [3]
    assert read.signals["value"][4] == 8.0
    infinite = read_signal_file(table(tmp_path / "i.csv", cell=lambda i: "inf" if i == 2 else "1"))
    assert np.isnan(infinite.signals["value"][2])


def test_channels_without_joints(tmp_path: Path) -> None:
    header = "time_s;channel:emg_1;channel:emg_2"
    lines = [header, *(f"{i / 10};{(-1) ** i};3" for i in range(12))]
    (tmp_path / "e.csv").write_text("\n".join(lines))
    read = read_signal_file(tmp_path / "e.csv")
    assert list(read.signals) == ["emg_envelope", "emg_1", "emg_2"]
    np.testing.assert_allclose(read.signals["emg_envelope"], 2.0)


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "is empty"),
        ("time,value\n" + "0,1\n" * 12, "row 1, column time_s is missing"),
        ("time_s,value,value\n" + "0,1,1\n" * 12, "row 1, column value is there twice"),
        ("time_s\n" + "".join(f"{i}\n" for i in range(12)), "holds no signal"),
        ("time_s,value\n" + "".join(f"{i},1\n" for i in range(9)), "9 frames; at least 10"),
        ("time_s,value\n" + "".join(f"{i % 11},1\n" for i in range(12)), "row 13, .*must increase"),
        ("time_s,value\n" + "".join(f"{i or ''},1\n" for i in range(12)), "row 2, .*not a finite"),
        ("time_s,value\nms,V\n" + "".join(f"{i},1\n" for i in range(12)), "unit 'ms'"),
        ("index_mcp_deg,time_s\n" + "".join(f"1,{i}\n" for i in range(12)), "is missing"),
    ],
)
def test_what_is_no_signal_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "s.csv").write_text(text)
    with pytest.raises(FileError, match=words) as raised:
        read_signal_file(tmp_path / "s.csv")
    assert str(raised.value).startswith(f"{tmp_path / 's.csv'}: ")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_signal_file(tmp_path / "s.csv")


def test_gaps_in_the_joints_are_refused(tmp_path: Path) -> None:
    text = postures_text(np.arange(12) / 10, np.ones((12, N_JOINTS)), {"d": np.ones(12)})
    lines = text.splitlines()
    lines[4] = lines[4].replace("57.295780", "", 1)
    (tmp_path / "s.csv").write_text("\n".join(lines))
    with pytest.raises(FileError, match="row 5, column thumb_rotation_deg"):
        read_signal_file(tmp_path / "s.csv")


KNOWN = [demonstration(distance_m=falling(), aperture_m=falling())]


def test_the_distance_is_taken_where_nothing_is_named() -> None:
    read = read_signal_file(PILLOW)
    name, values = chosen_channel(read, KNOWN, None, given=False)
    assert name == "distance_m"
    assert values is read.signals["distance_m"]
    assert chosen_channel(read, KNOWN, "palm_x_m", given=False)[0] == "palm_x_m"
    with pytest.raises(UnknownNameError, match="did you mean aperture_m"):
        chosen_channel(read, KNOWN, "apertur", given=False)


def test_a_lone_signal_needs_no_name_of_its_own(tmp_path: Path) -> None:
    read = read_signal_file(table(tmp_path / "s.csv"))
    name, values = chosen_channel(read, KNOWN, "distance_m", given=False)
    assert (name, values[2]) == ("distance_m", 2.0)
    assert chosen_channel(read, KNOWN, None, given=True)[0] == "value"
    with pytest.raises(InputError, match=r"holds value; .* hold aperture_m, distance_m; .*--range"):
        chosen_channel(read, KNOWN, None, given=False)
    with pytest.raises(InputError, match=r"hold no channels"):
        chosen_channel(read, [demonstration()], None, given=False)


def test_several_that_could_be_meant_are_named(tmp_path: Path) -> None:
    rows = [f"{i / 10},1,2,3,4,5,6,7" for i in range(12)]
    (tmp_path / "s.csv").write_text("\n".join(["time_s,a,b,c,d,e,f,g", *rows]))
    read = read_signal_file(tmp_path / "s.csv")
    with pytest.raises(InputError, match=r"holds a, b, c, d, e and 2 more; name one"):
        chosen_channel(read, KNOWN, None, given=True)
