"""The command line: options of any value, in any combination."""

import shutil

from hypothesis import strategies as st

from handsim.files import data_folder

from .conftest import SPECIAL, Sandbox, search

CONTROLLER = data_folder("assets") / "controller.npz"
POSTURES = data_folder("assets") / "experiments" / "cube-raise.csv"
SHORT = tuple(value for value in SPECIAL if len(value) < 10_000)
WORDS = st.sampled_from(SHORT) | st.text(max_size=6)
NUMBERS = st.sampled_from(SHORT) | st.floats().map(repr) | st.integers(-(10**12), 10**12).map(str)


def mostly(*good: str, else_: st.SearchStrategy = WORDS) -> st.SearchStrategy:
    """Good values three times out of four."""
    return st.integers(0, 3).flatmap(lambda i: st.sampled_from(good) if i else else_)


LENGTHS = mostly("0.16", "0.19", "0.25", else_=NUMBERS)
BREADTHS = mostly("0.08", "0.085", else_=NUMBERS)
TASKS = mostly("cube-raise", "jar-move", "tall-glass-drink")


@st.composite
def arguments(draw: st.DrawFn, fixed: tuple[str, ...], options: dict) -> list[str]:
    """Arguments of a command with some of its options, and at times one that it does not have."""
    chosen = list(fixed)
    for name, values in options.items():
        if draw(st.booleans()):
            value = draw(values)
            chosen += [name] if value is True else [f"{name}={value}"]
    if draw(st.integers(0, 9)) == 0:
        chosen.insert(draw(st.integers(1, len(chosen))), draw(WORDS))
    return chosen


FLAG = st.just(True)


def try_command(sandbox: Sandbox, cases: int, output: str | None, fixed, **options) -> None:
    named = {f"--{name.replace('_', '-')}": values for name, values in options.items()}

    def check(chosen: tuple[list[str], str]) -> None:
        arguments, name = chosen
        sandbox.fresh()
        where = [] if output is None else ["-o", f"{sandbox.outputs}/{name}"]
        sandbox.run(*arguments, *where)

    names = WORDS if output is None else mostly(output)
    search(check, st.tuples(arguments(fixed, named), names), cases * sandbox.cases)
    assert 2 in sandbox.codes


def test_postures(sandbox):
    try_command(
        sandbox, 60, "p.csv", ("postures",), task=TASKS, time_law=mostly("gradient"),
        duration=mostly("0.3", "600", else_=NUMBERS),
        goal=mostly(str(POSTURES), else_=st.sampled_from(["/", "/dev/zero", str(CONTROLLER)])),
    )  # fmt: skip


def test_drive(sandbox):
    """Without --range, since that takes two words; the recording drives itself by a channel."""
    people = data_folder("assets") / "people" / "pillow" / "pillow-03.csv"
    try_command(
        sandbox, 20, "d.csv", ("drive",), task=TASKS, channel=mostly("distance_m", "palm_x_m"),
        signal=mostly(str(people), str(POSTURES), else_=st.sampled_from(["/", str(CONTROLLER)])),
        speed=mostly("2", else_=NUMBERS), smoothing=mostly("0.1", else_=NUMBERS), json=FLAG,
    )  # fmt: skip


def test_hand_build(sandbox):
    sides = mostly("left", "right")
    try_command(
        sandbox,
        20,
        "hand",
        ("hand", "build"),
        hand_length=LENGTHS,
        hand_breadth=BREADTHS,
        side=sides,
    )


def test_recordings(sandbox):
    try_command(sandbox, 20, None, ("recordings", "info"), json=FLAG, bogus=WORDS)
    files = ("recordings", "import", str(POSTURES))
    formats = mostly("west-rtg")
    try_command(sandbox, 20, "set", files, format=formats, subject=NUMBERS)


def test_evaluate_and_certify(sandbox):
    try_command(sandbox, 8, None, ("evaluate",), json=FLAG, bogus=WORDS)
    try_command(sandbox, 4, None, ("certify", "nowhere.npz"), json=FLAG)


def test_learn(sandbox):
    try_command(
        sandbox, 5, "c.npz", ("learn",), components=mostly("2", "3", else_=NUMBERS),
        method=mostly("direction"), k=mostly("2", "10", else_=NUMBERS), seed=NUMBERS,
    )  # fmt: skip


def test_grasp(sandbox):
    try_command(
        sandbox, 14, "rollouts", ("grasp", str(CONTROLLER), "--replay"), task=TASKS,
        seed=mostly("7", else_=NUMBERS), hand_length=LENGTHS, hand_breadth=BREADTHS,
        friction=mostly("0.3", "1.5", else_=NUMBERS), trials=mostly("0", "1"), json=FLAG,
        side=mostly("left", "right"), leave_out=mostly("cube", "jar"),
        jobs=mostly("1", else_=st.sampled_from(["0", "-1", "many", "9999"])),
        protocol=mostly("lift", "six-axis"), recordings=mostly(str(POSTURES.parent)),
    )  # fmt: skip


SWEEP = {
    "tasks": ['["cube-raise"]', '"all"', '["cube-raise", "jar-move"]'],
    "controllers": ['["demonstrator"]', '["built-in"]', '["c.npz"]'],
    "hands": ['["woman-5"]', "[{length = 0.17, breadth = 0.08}]"],
    "population": ['{sex = "woman", count = 2}', '[{sex = "man", count = 1, seed = 3}]'],
    "sides": ['["left"]', '["right", "left"]'],
    "frictions": ["[0.5, 1]"],
    "mass_scales": ["[0.5]"],
    "seeds": ["1", "[0, 7]"],
}
VALUES = st.sampled_from(SHORT).map(lambda word: f'"{word}"') | st.sampled_from(SHORT) | NUMBERS


@st.composite
def sweeps(draw: st.DrawFn) -> tuple[str, bool]:
    """A TOML file with at least one thing wrong most of the time, and whether nothing is."""
    lines, good = [], True
    for key, values in SWEEP.items():
        if key in ("tasks", "controllers") or draw(st.booleans()):
            value = draw(st.sampled_from(values))
            kind = draw(st.sampled_from(["as it is"] * 6 + ["value", "list", "key", "cut"]))
            good &= kind == "as it is"
            if kind in ("value", "list"):
                odd = draw(VALUES)
                value = odd if kind == "value" else f"[{odd}]"
            name = draw(WORDS) if kind == "key" else key
            lines.append(f"{name} = {value}"[: 5 if kind == "cut" else None])
    return "\n".join(lines) + "\n", good


def test_sweep(sandbox, monkeypatch):
    """No grasp is made: what can be swept is told by its number of runs."""
    monkeypatch.setattr("handsim.grasping.sweep.runner.sweep", lambda *args: None)
    monkeypatch.setattr("handsim.grasping.sweep.graspers.SweepGraspers.plan", lambda *args: None)

    def check(chosen: tuple[str, bool]) -> None:
        text, good = chosen
        sandbox.fresh()
        shutil.copy(CONTROLLER, sandbox.inputs / "c.npz")
        (sandbox.inputs / "s.toml").write_text(text, encoding="utf-8", errors="replace")
        code = sandbox.run("sweep", sandbox.inputs / "s.toml", "-o", sandbox.outputs / "r.csv")
        assert code == 0 or not good

    search(check, sweeps(), 100 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_render(sandbox):
    odd = st.sampled_from(["0x0", "16x99999", "1e3x2", "9" * 5000 + "x1", "-1x-1", "64x48x2"])
    sizes = mostly("64x48", else_=odd | WORDS)
    cameras = mostly("palm", "orbit")
    counts = mostly("2", "3", else_=st.sampled_from(["9999", "1000000000"]) | NUMBERS)
    try_command(
        sandbox, 16, "p.png", ("render", str(POSTURES), "--postures=2"), size=sizes,
        fps=mostly("30", else_=NUMBERS), camera=cameras, postures=counts, plain=FLAG,
    )  # fmt: skip


def test_words_instead_of_commands(sandbox):
    words = st.sampled_from(["grasp", "hand", "build", "--help", "--", "-o", "--json"]) | WORDS

    def check(arguments: list[str]) -> None:
        sandbox.fresh()
        sandbox.run(*arguments)

    search(check, st.lists(words, max_size=4), 40 * sandbox.cases)


def test_outputs_that_cannot_be(sandbox):
    """A folder, a link to nowhere and a link to a file of others in place of the output."""
    sandbox.fresh()
    (sandbox.outputs / "folder.csv").mkdir()
    (sandbox.outputs / "loop.csv").symlink_to(sandbox.outputs / "loop.csv")
    shutil.copy(POSTURES, sandbox.inputs / "own.csv")
    (sandbox.outputs / "link.csv").symlink_to(sandbox.inputs / "own.csv")
    for name, code in (("folder.csv", 2), ("loop.csv", 0), ("link.csv", 0)):
        assert sandbox.run("postures", "--task", "cube-raise", "-o", sandbox.outputs / name) == code
    # The link is replaced, and not what it leads to.
    assert (sandbox.inputs / "own.csv").read_bytes() == POSTURES.read_bytes()
