"""Compare ways to learn reaching movements, and print the tables of the README.

Run: python -m tests.benchmarks.rivals FOLDER... [-o table.md] [--folds N] [--jobs N]

A folder holds recordings in handsim's format (one set a person) or ``.npz`` files of handwriting
(one set a file, ``pos`` and ``t``). Without folders the 24 built-in experiments are taken.
"""

import argparse
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from time import perf_counter

from handsim.errors import HandsimError, InputError
from handsim.files import check_target, data_folder, write_text
from handsim.grasping.pool import in_order, one_by_one, processes

from .data import TrialSet, read_sets
from .registry import RIVALS, VARIANTS, Rivals
from .running import measure
from .table import Row, machine, tables


def main(words: list[str] | None = None) -> int:
    """Run the command; return its exit code."""
    asked = _arguments(words)
    folders: list[Path] = asked.folders or [data_folder("assets") / "experiments"]
    try:
        if asked.output:
            check_target(asked.output)
        rivals = _chosen(VARIANTS if asked.variants else RIVALS, asked.only)
        every = [(folder.name, read_sets(folder)) for folder in folders]
        text = machine() + "\n"
        for name, sets in every:
            text += "\n"
            so_far = text
            rows: list[Row] = []
            for row in _rows(rivals, sets, asked.folds, asked.jobs):
                rows.append(row)
                so_far = text + tables(name, sets, rows, asked.folds)
                if asked.output:  # what was found is kept, whatever stops the rest
                    write_text(asked.output, so_far)
            text = so_far
        if not asked.output:
            print(text)
    except HandsimError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.rivals", description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("-o", "--output", type=Path, help="file for the tables")
    parser.add_argument("--folds", type=int, default=10, help="even folds left out")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--only", nargs="+", help="names of rivals, or parts of them")
    parser.add_argument("--variants", action="store_true", help="settings of ours instead")
    asked = parser.parse_args(words)
    for name in ("folds", "jobs"):
        least = 2 if name == "folds" else 1
        if getattr(asked, name) < least:
            parser.error(f"--{name} {getattr(asked, name)}; give {least} or more")
    return asked


def _chosen(rivals: Rivals, parts: list[str] | None) -> Rivals:
    found = {
        name: make
        for name, make in rivals.items()
        if parts is None or any(part in name for part in parts)
    }
    if not found:
        raise InputError(f"no rival is called {' or '.join(parts or [])}; {', '.join(rivals)} are")
    return found


def _rows(rivals: Rivals, sets: tuple[TrialSet, ...], n_folds: int, n_jobs: int) -> Iterator[Row]:
    """Yield a row for each rival, as it is done."""
    pool = one_by_one if n_jobs == 1 else processes(n_jobs)
    jobs = [(make, each, n_folds) for make in rivals.values() for each in sets]
    found = in_order(pool, measure, jobs)
    began = perf_counter()
    for name in rivals:
        yield Row(name, list(islice(found, len(sets))))
        print(f"{name}: {perf_counter() - began:.0f} s", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
