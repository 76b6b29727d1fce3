"""Why answers moved: what changed among all that they depend on.

A changed recording moves every movement of a controller learned again. That is one thing to be
told, and not one a movement.
"""

from collections.abc import Mapping, Sequence

from handsim.baseline.findings import Finding
from handsim.baseline.inputs import SCHEMA_OF_INPUTS

UNKNOWN = "nothing that is compared changed but the code"
"""The cause of what no input, version or environment explains."""
_MOST_NAMED = 4
_DIGEST = 16  # hexadecimal digits of an array's digest; what is shorter or no number is a setting


def causes_of(
    findings: Sequence[Finding],
    before: Mapping[str, str],
    after: Mapping[str, str],
    elsewhere: Sequence[str] = (),
) -> tuple[tuple[str, tuple[Finding, ...]], ...]:
    """Return what changed and the findings that follow from it, each finding under one cause.

    Parameters
    ----------
    findings
        Worst first; those of changed inputs join the cause that names them.
    before, after
        Inputs of the baseline and of now.
    elsewhere
        Differences of version and environment, which explain what no input does.
    """
    changed = changed_inputs(before, after)
    found: dict[str, list[Finding]] = {}
    for finding in (each for each in findings if each.kind != "input"):
        text = "; ".join(_inputs_in_words(finding.name, changed)) or _other(finding, elsewhere)
        found.setdefault(text, []).append(finding)
    for finding in (each for each in findings if each.kind == "input"):
        text = next((text for text in found if _names(finding.name, text)), None)
        found.setdefault(text or f"{finding.name} {finding.text}", []).append(finding)
    return tuple((text, tuple(of_cause)) for text, of_cause in found.items())


def _other(finding: Finding, elsewhere: Sequence[str]) -> str:
    """Return what may be the cause of a finding that no input explains."""
    if not elsewhere:
        return f"{UNKNOWN} ({finding.kind})"
    return "; ".join(elsewhere[:2]) + ("" if finding.kind == "environment" else "; or the code")


def changed_inputs(
    before: Mapping[str, str], after: Mapping[str, str]
) -> dict[str, tuple[str, str]]:
    """Return the inputs that differ, with both values; '' where there is none."""
    if before.get(SCHEMA_OF_INPUTS) != after.get(SCHEMA_OF_INPUTS):
        return {}
    names = dict.fromkeys([*before, *after])
    both = {name: (before.get(name, ""), after.get(name, "")) for name in names}
    return {name: (old, new) for name, (old, new) in both.items() if old != new}


def _inputs_in_words(answer: str, changed: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return which changed inputs an answer depends on."""
    family, _, task = answer.partition("/")
    recordings = [name for name in changed if name.startswith("recordings/")]
    of_controller = {n: both for n, both in changed.items() if n.startswith("controller/")}
    words = options_in_words(of_controller)
    # A controller that was learned from other recordings differs in all its numbers.
    if recordings and (family == "relearned" or of_controller):
        words.append(f"recordings changed ({_listed(recordings)})")
    if of_controller and not words:
        words.append(f"controller changed ({_listed(list(of_controller))})")
    if family == "grasp":
        for name, (old, new) in changed.items():
            group, _, place = name.partition("/")
            if group == "condition":
                words.append(f"{name} {old or 'none'} in the baseline, {new or 'none'} now")
            elif place == task:
                words.append(f"{group} changed")
    return words


def options_in_words(of_controller: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings of a controller that changed, with both values."""
    changed: dict[str, str] = {}
    for name, (old, new) in of_controller.items():
        if _is_digest(old) or _is_digest(new):
            continue
        setting = name.partition("/")[2]
        one, other = (_entries(setting, value) for value in (old, new))
        for entry in dict.fromkeys([*one, *other]):
            was, now = one.get(entry, "none"), other.get(entry, "none")
            if was != now:
                changed[entry] = f"option {entry} {was} in the baseline, {now} now"
    kept = list(changed.values())
    return [
        *kept[:_MOST_NAMED],
        *([f"{len(kept) - _MOST_NAMED} more"] if kept[_MOST_NAMED:] else []),
    ]


def _entries(setting: str, value: str) -> dict[str, str]:
    """Return the settings in a value: itself, or the entries of a table."""
    pairs = [entry.partition(" ") for entry in value.split(", ")]
    if not all(pair[2] for pair in pairs):
        return {setting: value}
    return {name: said for name, _, said in pairs}


def _is_digest(value: str) -> bool:
    return len(value) == _DIGEST and set(value) <= set("0123456789abcdef")


def _names(group: str, text: str) -> bool:
    """Whether a cause names a group of inputs."""
    return (
        f"{group} changed" in text or group in text or (group == "controller" and "option " in text)
    )


def _listed(names: Sequence[str]) -> str:
    short = [name.partition("/")[2] for name in names[:_MOST_NAMED]]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return ", ".join(short) + more
