"""What pages take from the code as it is: the API, the tasks, the objects, schema numbers.

The pages of the API are written to docs/api before each build, one a room, so that a new module
is in them without further ado.
"""

import ast
import re
import tomllib
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

from command_help import help_of_all
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import handsim
from handsim.baseline import store as baseline_store
from handsim.cli.listing.rule_words import rule_in_words
from handsim.grasping import rollout_file
from handsim.grasping.planning import plan_store
from handsim.joints import JOINTS
from handsim.learning import controller
from handsim.objects.catalogue import OBJECTS
from handsim.recordings.glove.calibrate import POSTURES
from handsim.tasks.grip_rules import MAX_PENETRATION
from handsim.tasks.rules import TRACE_HEIGHT
from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS
from handsim.tasks.task import Task

PACKAGE = Path(handsim.__file__).parent
VERSION = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())["project"]["version"]

SUBSTITUTIONS = {
    "controller_schema": controller.SCHEMA,
    "plan_schema": plan_store.SCHEMA,
    "rollout_schema": rollout_file.SCHEMA,
    "baseline_schema": baseline_store.SCHEMA,
    "max_penetration": f"{1000 * MAX_PENETRATION:g} mm",
    "trace_height": f"{1000 * TRACE_HEIGHT:g} mm",
}
"""What pages may name as ``{{ name }}``."""

ROOMS = (
    "recordings", "recordings.columns", "recordings.cutting", "recordings.fitting",
    "recordings.glove", "recordings.importers", "recordings.importers.ninapro",
    "recordings.points", "navigation", "navigation.proof", "learning", "learning.direction",
    "learning.general", "learning.guide", "learning.movement", "learning.pde", "learning.fit",
    "learning.transport", "driving", "hand", "arm", "objects", "objects.meshes", "tasks",
    "retargeting", "retargeting.solving", "robot_hands", "robot_hands.reading", "grasping",
    "grasping.gripping", "grasping.planning", "grasping.planning.trials", "grasping.rollout",
    "grasping.judging", "grasping.robots", "grasping.sweep", "baseline", "testing", "environments",
    "exports", "exports.lerobot", "viewing", "viewing.stage", "viewing.film", "viewing.figures",
    "viewing.live", "viewing.live.pushing", "viewing.live.subspace", "viewing.opengl", "cli",
    "cli.exporting", "cli.listing", "cli.recordings",
)  # fmt: skip


def public_names() -> list[tuple[str, str]]:
    """Return the public names of the package and the modules that define them, from the stub."""
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    return [
        (alias.asname or alias.name, f"handsim.{node.module}")
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]


def defined_in(name: str, module: str) -> str:
    """Return the full name under which a public name is documented: that of its definition."""
    value = getattr(import_module(module), name)
    home = getattr(value, "__module__", None) if callable(value) else None
    if home is None or not home.startswith("handsim"):
        home = _assigned_in(name, module)
    return f"{home}.{name}"


def _assigned_in(name: str, module: str) -> str:
    """Follow imports of a constant to the module that assigns it."""
    path = Path(import_module(module).__file__ or "")
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and name in [alias.name for alias in node.names]:
            return _assigned_in(name, node.module or module)
    return module


def summary_of(full_name: str) -> str:
    """Return the first line of a name's docstring, or the text after a constant."""
    module, _, name = full_name.rpartition(".")
    value = getattr(import_module(module), name)
    if callable(value):
        return (value.__doc__ or "").strip().splitlines()[0]
    body = ast.parse(Path(import_module(module).__file__ or "").read_text(encoding="utf-8")).body
    for node, following in pairwise(body):
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        said = following.value if isinstance(following, ast.Expr) else None
        if isinstance(target, ast.Name) and target.id == name and isinstance(said, ast.Constant):
            return str(said.value).strip().splitlines()[0]
    return ""


def modules_of(room: str) -> list[str]:
    """Return the modules of a room that others may import."""
    folder = PACKAGE.joinpath(*room.split("."))
    names = sorted(path.stem for path in folder.glob("*.py") if not path.name.startswith("_"))
    return [f"handsim.{room}.{name}" for name in names]


def write_api(app: Sphinx) -> None:
    """Write a page a room, and one of the modules beside the rooms, where they have changed."""
    folder = Path(app.srcdir) / "api"
    folder.mkdir(exist_ok=True)
    beside = sorted(path.stem for path in PACKAGE.glob("*.py") if not path.name.startswith("_"))
    pages = {room: [f"handsim.{room}", *modules_of(room)] for room in ROOMS}
    pages["beside"] = [f"handsim.{name}" for name in beside]
    for name, modules in pages.items():
        title = "Beside the rooms" if name == "beside" else _breakable(f"handsim.{name}")
        text = f"{title}\n{'=' * len(title)}\n\n" + "\n".join(map(_of_module, modules))
        page = folder / f"{name}.rst"
        if not page.is_file() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")
    for page in folder.glob("*.rst"):
        if page.stem not in pages:
            page.unlink()


def _breakable(name: str) -> str:
    """Let a long name be broken behind its dots, by spaces without width."""
    return name.replace(".", ".\u200b")


def _of_module(module: str) -> str:
    if module.removeprefix("handsim.") in ROOMS:
        return f".. automodule:: {module}\n   :no-members:\n"
    title = _breakable(module)
    line = "-" * len(title)
    return f"{title}\n{line}\n\n.. automodule:: {module}\n   :ignore-module-all:\n"


class FromCode(SphinxDirective):
    """Put in Markdown that a function makes: ``{from-code} NAME``."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Parse what the function returns as if it stood on the page."""
        made = MAKERS[self.arguments[0]]()
        return self.parse_text_to_nodes(made, allow_section_headings=True)


def public_table() -> str:
    """Return a table of the public names with links and first lines."""
    rows = ["| name | what it is |", "|---|---|"]
    for name, module in sorted(public_names(), key=lambda each: each[0].lower()):
        full = defined_in(name, module)
        rows.append(f"| {{py:obj}}`handsim.{name} <{full}>` | {_cell(summary_of(full))} |")
    return "\n".join(rows)


def task_table() -> str:
    """Return the table of tasks with what each asks for."""
    rows = ["| No. | task | object | grasp | movements after the squeeze | rule |",
            "|---|---|---|---|---|---|"]  # fmt: skip
    for task in (*TASKS, PHONE_TODAY_VIEW):
        number = task.number if task is not PHONE_TODAY_VIEW else "21b"
        grasp = f"{task.grasp.kind}, {1000 * task.grasp.width:.0f} mm"
        rows.append(
            f"| {number} | `{task.name}` | {task.object_name} | {grasp} | {_steps(task)} "
            f"| {rule_in_words(task)} |"
        )
    return "\n".join(rows)


def _steps(task: Task) -> str:
    said = []
    for step in task.steps:
        moved = [f"{1000 * value:g}" for value in step.shift]
        parts = [f"shift ({', '.join(moved)}) mm"] if any(step.shift) else []
        if step.angle_deg and step.flex:
            parts.append(f"flex {', '.join(step.flex)} by {step.angle_deg:g} deg")
        elif step.angle_deg:
            axis = ", ".join(f"{value:g}" for value in step.axis)
            parts.append(f"turn {step.angle_deg:g} deg about ({axis})")
        said.append(f"{' and '.join(parts)} in {step.seconds:g} s")
    return "; ".join(said)


def object_table() -> str:
    """Return the table of objects."""
    rows = ["| object | mass | parts on hinges | +x is | sizes and masses from |",
            "|---|---|---|---|---|"]  # fmt: skip
    for each in OBJECTS.values():
        hinges = ", ".join(f"`{link.hinge.name}`" for link in each.links)
        rows.append(
            f"| {each.name} | {1000 * each.mass:.0f} g | {hinges} | {each.front} | {each.source} |"
        )
    return "\n".join(rows)


def joint_table() -> str:
    """Return the table of the 22 joints."""
    rows = ["| | joint | a positive angle | range |", "|---|---|---|---|"]
    for i, joint in enumerate(JOINTS):
        rows.append(
            f"| {i} | `{joint.name}` | {joint.motion} | {joint.lower_deg:g} to "
            f"{joint.upper_deg:g} deg |"
        )
    return "\n".join(rows)


def posture_table() -> str:
    """Return the table of postures by which a glove is calibrated."""
    rows = ["| file begins with | angles, deg |", "|---|---|"]
    for name, angles in POSTURES.items():
        if any(angles.values()):
            said = ", ".join(f"`{joint}` {angle:g}" for joint, angle in angles.items() if angle)
            others = [joint for joint, angle in angles.items() if not angle]
            said += f"; the other {len(others)} stated are 0" if others else ""
        else:
            said = "all 0: fingers together, thumb beside the index finger, wrist straight"
        rows.append(f"| `{name}` | {said} |")
    return "\n".join(rows)


def entry_table() -> str:
    """Return the table of what actions and observations of the environment are."""
    from handsim.environments.entries import ACTION_KINDS, action_entry, observation_entries

    seen = [(f'`["{entry.name}"]`', entry) for entry in observation_entries(3, 9.99)]
    given = [(f'`action="{kind}"`', action_entry(kind, 3)) for kind in ACTION_KINDS]
    rows = ["| | numbers | unit | meaning | bounds |", "|---|---|---|---|---|"]
    for name, entry in (*given, *seen):
        high = "end of the run" if entry.name == "time" else f"{entry.high:g}"
        rows.append(
            f"| {name} | {entry.size} | {entry.unit} | {entry.meaning} | {entry.low:g} to {high} |"
        )
    return "\n".join(rows)


MAKERS = {
    "commands": help_of_all,
    "entries": entry_table,
    "joints": joint_table,
    "objects": object_table,
    "postures": posture_table,
    "public": public_table,
    "tasks": task_table,
}


def _cell(text: str) -> str:
    """Return text of a docstring as it may stand in a cell of a Markdown table."""
    return text.replace("``", "`").replace("|", r"\|")


_NUMBERED = re.compile(r"\[\d+\] ")
_LITERAL = re.compile(r"(``.*?``|`[^`]*`_?)")


def readable(app: Sphinx, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Keep formulas in docstrings from being read as markup.

    Bars, asterisks and trailing underscores stand for themselves. An indented paragraph of
    a module's docstring is a formula and keeps its lines. Its headings become bold lines, since
    numpydoc knows only headings of its own, and its numbered sources a list.
    """
    changed: list[str] = []
    literal = False
    for i, line in enumerate(lines):
        blank_before = not changed or not changed[-1].strip()
        if literal and line.strip() and not line.startswith("    "):
            literal = False
        if what == "module" and not literal and blank_before and line.startswith("    "):
            before = next((each for each in reversed(changed) if each.strip()), "")
            if not before.endswith("::"):
                changed += ["::", ""]
            literal = True
        if what == "module" and line and set(line) == {"-"} and lines[i - 1].strip():
            changed[-1:] = [f"**{changed[-1].strip()}**", ""]
        elif what == "module" and _NUMBERED.match(line):
            changed += ["", f"- {_escaped(line)}"]
        elif what == "module" and not literal and line.startswith("    "):
            changed.append(f"  {_escaped(line.strip())}")  # goes on with an item
        else:
            changed.append(line if literal or line.lstrip().startswith(">>>") else _escaped(line))
    lines[:] = changed


def _escaped(line: str) -> str:
    parts = _LITERAL.split(line)
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r"(?<!\\)([|*])", r"\\\1", parts[i])
        parts[i] = re.sub(r"(?<=\w)_(?!\w)", r"\\_", parts[i])
    return "".join(parts)


_ARRAY_LIKE = re.compile(r"~?[\w.]*_Buffer \| [^=]*?bytes \| str\](?= = |, |\))")
_ARRAY = re.compile(
    r"~?numpy\.ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?numpy\.dtype\[~?numpy\.float64\]\]"
)


def shorter(
    app: Sphinx, what: str, name: str, value: Any, options: Any, signature: str, returned: str
) -> tuple[str | None, ...] | None:
    """Write ``Array`` and ``ArrayLike`` in signatures, as the code does.

    Constants have none, though those that name a type can be called.
    """
    if what not in ("class", "exception", "function", "method"):
        return None, ""
    if signature is None:
        return None
    return tuple(
        each and _ARRAY_LIKE.sub("ArrayLike", _ARRAY.sub("Array", each))
        for each in (signature, returned)
    )


def setup(app: Sphinx) -> dict[str, Any]:
    """Hand it all to Sphinx."""
    app.add_directive("from-code", FromCode)
    # Before autosummary reads the pages of an earlier build, of modules that may have moved.
    app.connect("builder-inited", write_api, priority=400)
    app.connect("autodoc-process-docstring", readable, priority=400)
    app.connect("autodoc-process-signature", shorter, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
