"""Page of the mutation tests: changes detected by package, and every change not detected."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml
from mutation_sites import Mutation

#: Changes that change no result (`equivalent`), and survivors with the reason they are left.
JUDGED: Final = Path(__file__).with_name("mutants_judged.yaml")

_HEAD: Final = """# Mutation tests

`make mutants` makes {total} small changes to the sources, one at a time (`<` to `<=`, `+` to `-`, a
number, a sign, `min` to `max`, ...), drawn with a fixed seed, and runs the tests that reach the
changed line until one fails: for {budget_s[0]:g} s, what survives for {budget_s[1]:g} s. Slow tests
and those of the workflow are left out. Finished changes are not repeated.
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
    detected = 100.0 * (1.0 - len(left) / max(len(counted), 1))
    share = 100.0 * noticed / max(len(counted), 1)
    of_package = Counter(each.file.split("/")[0] for each in counted)
    left_of_package = Counter(each.file.split("/")[0] for each in left)
    lines = [
        _HEAD.format(total=len(sample), budget_s=budget_s),
        f"Tried: {len(ran)} of {len(sample)}. {len(equivalent)} of them change no result (reasons "
        f"in `benchmarks/mutants_judged.yaml`). Of the other {len(counted)}, tests detected "
        f"**{len(counted) - len(left)} ({detected:.0f} %)**, and {noticed} "
        f"({share:.0f} %) when the changes were first tried.\n",
        "| package | tried | detected |",
        "| --- | ---: | ---: |",
        *(f"| `{p}` | {n} | {n - left_of_package[p]} |" for p, n in sorted(of_package.items())),
        "",
        "## Not detected",
        "",
        *_table(left, judged, "no test yet"),
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
