"""What an analysis costs before it has run: from those that have, or a constant."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from typing import Any, Final

from skewbridge.study.task import Task

#: Processor seconds per second of motion where no analysis has been measured yet.
#: source: docs/scaling.md, 4 s for 25 s of motion, two-column bridge, default steps
CPU_S_PER_MOTION_S: Final = 0.16


def forecast_cpu_s(
    tasks: Sequence[Task], keys: Sequence[str], done: Mapping[str, Mapping[str, Any]]
) -> list[float]:
    """Return the processor seconds that each analysis will take; 0 for those that are done.

    The rate per second of motion is that of the finished ones among the given analyses, with the
    same bridge and abutment model if there are such.

    Args:
        tasks: The analyses.
        keys: Their `run_key`.
        done: Rows of finished analyses by `run_key`.
    """
    measured: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for task, key in zip(tasks, keys, strict=True):
        if key in done and isfinite(done[key]["cpu_s"]):
            times = done[key]["cpu_s"], analysed_s(task)
            measured.setdefault(_kind(task), []).append(times)
    rates = {kind: _rate(times) for kind, times in measured.items()}
    otherwise = _rate([each for times in measured.values() for each in times])
    return [
        0.0 if key in done else analysed_s(task) * rates.get(_kind(task), otherwise)
        for task, key in zip(tasks, keys, strict=True)
    ]


def analysed_s(task: Task) -> float:
    """Return how many seconds of its motion an analysis takes at most."""
    longest = task.settings.duration_s
    return min(task.motion.motion.duration_s, inf if longest is None else longest)


def _kind(task: Task) -> tuple[str, str]:
    return task.variant.bridge_name, task.variant.abutment


def _rate(times: Sequence[tuple[float, float]]) -> float:
    cpu_s, motion_s = (sum(part) for part in zip(*times, strict=True)) if times else (0.0, 0.0)
    return cpu_s / motion_s if cpu_s > 0.0 else CPU_S_PER_MOTION_S
