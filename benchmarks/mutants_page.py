"""The page of the small changes: how many the tests noticed, and each that they did not."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml
from mutation_sites import Mutation

#: Changes that change no result (`equivalent`), and survivors with the reason they are left.
JUDGED: Final = Path(__file__).with_name("mutants_judged.yaml")

_HEAD: Final = """# What the tests notice

`make mutants` changes the sources in small ways, one at a time (`<` to `<=`, `+` to `-`, a number,
a sign, `min` to `max`, ...), and runs the tests that reach the changed line until one fails. The
{total} changes are drawn with a fixed seed from all of `contact`, `bridge`, `analysis`, `demands`,
`fragility` and `motions`; texts, messages and annotations are not changed. A change is tried
against {budget_s[0]:g} s of tests at most, the shortest first, and what survives them against
{budget_s[1]:g} s once more; the workflow and the tests called slow are left out, so that what they
alone would notice counts as not noticed. A change with which tests cannot be loaded is noticed.

The program is our own (`benchmarks/mutants.py`); mutmut and cosmic-ray were not tried. What it
is for: a sample whose first part is a sample as well, and a limit on the seconds of tests, since
five minutes of tests for each change are a day for 200.
"""


def page(sample: Sequence[Mutation], entries: Iterable[Mapping[str, Any]], budget_s: float) -> str:
    """Return the page as Markdown.

    Args:
        sample: The changes drawn.
        entries: What became of them; of two lines for one change the last counts.
        budget_s: Seconds of tests that a change was tried against at first and again.
    """
    every = list(entries)
    fates = {entry["mutant"]: entry for entry in every}
    first = {entry["mutant"]: entry["fate"] for entry in reversed(every)}
    judged = yaml.safe_load(JUDGED.read_text()) if JUDGED.exists() else {}
    ran = [
        each for each in sample if fates.get(each.name, {}).get("fate") in {"killed", "survived"}
    ]
    survived = [each for each in ran if fates[each.name]["fate"] == "survived"]
    equivalent = [each for each in survived if _verdict(judged, each)[0] == "equivalent"]
    counted = [each for each in ran if each not in equivalent]
    left = [each for each in survived if each not in equivalent]
    noticed = sum(first[each.name] == "killed" for each in counted)
    share = 100.0 * noticed / max(len(counted), 1)
    of_package = Counter(each.file.split("/")[0] for each in counted)
    left_of_package = Counter(each.file.split("/")[0] for each in left)
    lines = [
        _HEAD.format(total=len(sample), budget_s=budget_s),
        f"Tried: {len(ran)} of {len(sample)}. Without the {len(equivalent)} that change no result, "
        f"**{len(counted) - len(left)} of {len(counted)} were noticed "
        f"({100.0 * (1.0 - len(left) / max(len(counted), 1)):.0f} %)**.\n",
        f"At first it was {noticed} ({share:.0f} %): the others were noticed by tests written "
        "since, or by more\nseconds of tests. Of changes that were not drawn the first share is "
        "the most to expect.\n",
        "| package | tried | noticed |",
        "| --- | ---: | ---: |",
        *(f"| `{p}` | {n} | {n - left_of_package[p]} |" for p, n in sorted(of_package.items())),
        "",
        "## Not noticed",
        "",
        *_table(left, judged, "no test yet"),
        "",
        "## Changes of no result",
        "",
        *_table(equivalent, judged, ""),
        "",
    ]
    return "\n".join(lines)


def _table(changes: Sequence[Mutation], judged: Mapping[str, str], unjudged: str) -> list[str]:
    if not changes:
        return ["None."]
    rows = [
        f"| `{each.file}` {each.where} | `{_cell(each.was)}` | `{_cell(each.becomes)}` | "
        f"{_verdict(judged, each)[1] or unjudged} |"
        for each in changes
    ]
    return ["| where | is | changed to | reason |", "| --- | --- | --- | --- |", *rows]


def _cell(code: str) -> str:
    return code.replace("|", "\\|")


def _verdict(judged: Mapping[str, str], change: Mutation) -> tuple[str, str]:
    """Return `equivalent` or `left`, and the reason."""
    verdict, _, reason = judged.get(change.name, "left: ").partition(": ")
    return verdict, reason
