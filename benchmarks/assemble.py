"""Collect the results of the benchmarks in results/benchmarks.json, with versions and set sizes.

    python benchmarks/assemble.py

`run.sh` writes one JSON file per entry to results/benchmarks. An entry without a file was not
measured: it is null in the result and named on stderr. The script prints the lines for
docs/scaling.md.
"""

import json
import os
import sys
from collections.abc import Iterator, Mapping
from typing import Any, Final

from common import RESULTS, versions

#: Entries of the result and the files that hold them.
ENTRIES: Final = (
    "speedup",
    "overhead",
    "native",
    "workers",
    "pipeline",
    "contact_update",
    "motions",
    "fragility",
)
TARGET: Final = RESULTS.with_suffix(".json")
#: Main measure of an entry, copied to its `ratio`.
RATIOS: Final = {
    "speedup": "speedup",
    "overhead": "overhead",
    "parallel": "throughput_two_over_one",
    "pipeline": "pipeline",
}


def assembled() -> dict[str, Any]:
    """Return all entries; None for those that were not measured."""
    found = {name: _read(name) for name in ENTRIES}
    workers = found.pop("workers") or {}
    parts = {"parallel": workers.get("parallel"), "memory": workers.get("memory")}
    about = {"versions": versions(), "cores": os.cpu_count()}
    result = about | found | parts
    for name, measure in RATIOS.items():
        if entry := result[name]:
            value = entry[measure]
            entry["ratio"] = value["median"] if isinstance(value, dict) else value
    return result


def _read(name: str) -> Any:
    path = RESULTS / f"{name}.json"
    text = path.read_text("utf-8").strip() if path.exists() else ""
    return json.loads(text) if text else None


def table(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of the table in Markdown."""
    yield "| quantity | median | smallest to largest | cases | target |"
    yield "|---|---|---|---|---|"
    if speed := found["speedup"]:
        text = f"plain numerics over ours, {speed['accuracy']} ({speed['cases']} cases)"
        yield _line(text, speed["speedup"], "at least 15")
        of_ours = speed["cpu_s_per_record_s"]["ours"]
        yield f"| processor seconds per second of motion | {of_ours:.3f} | | | |"
    if overhead := found["overhead"]:
        text = "analysis of the default study over its bare OpenSees commands"
        yield _line(text, overhead["overhead"], "at most 1.10")
    if native := found["native"]:
        for name, case in native["cases"].items():
            text = f"`zeroLengthContactASDimplex` over ours, deck {name}"
            yield _line(text, case["native_over_ours"])
    if parallel := found["parallel"]:
        text = f"two workers over one (load {parallel['load_average']:.1f})"
        yield _line(text, parallel["throughput_two_over_one"], "at least 1.85")
        text = "processor time of an analysis, two workers over one"
        yield _line(text, parallel["cpu_per_analysis_two_over_one"])
    if pipeline := found["pipeline"]:
        count = pipeline["motions_per_variant"]
        text = f"analysis stage x cores over its processor time, {count} motions per variant"
        yield f"| {text} | {pipeline['pipeline']:.2f} | | 1 | at most 1.10 |"
    if memory := found["memory"]:
        growth = memory["growth_mb_per_100"]
        text = f"growth of a worker, MB per 100 analyses ({memory['analyses']} of them)"
        yield f"| {text} | {growth:.2f} | | | at most 1 |"
        yield f"| memory of a worker, MB | {memory['largest_mb']:.0f} | | | |"
    if speed:
        yield ""
        yield "| change against `accuracy: reference`, per cent | plain | ours |"
        yield "|---|---|---|"
        for demand, errors in speed["error_percent"].items():
            cells = [
                f"{errors[program]['median']:.2f}, {errors[program]['largest']:.2f}"
                for program in ("plain", "ours")
            ]
            yield f"| {demand}: median, largest | {' | '.join(cells)} |"


def _line(text: str, found: Mapping[str, float], target: str = "") -> str:
    limits = f"{found['least']:.2f} to {found['largest']:.2f}"
    return f"| {text} | {found['median']:.2f} | {limits} | {found['count']:g} | {target} |"


def main() -> None:
    """Write the result; print the table, and the entries not measured to stderr."""
    found = assembled()
    TARGET.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    missing = [name for name, entry in found.items() if entry is None]
    if missing:
        sys.stderr.write(f"not measured: {', '.join(missing)}\n")
    sys.stdout.write("\n".join(table(found)) + "\n")


if __name__ == "__main__":
    main()
