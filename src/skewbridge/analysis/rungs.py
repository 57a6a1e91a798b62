"""How many steps and analyses each rung of the recovery ladder carried."""

from collections.abc import Iterable
from typing import Any

from skewbridge.analysis.recovery import LADDER, Attempt


def as_text(steps_by_rung: Iterable[int]) -> str:
    """Return the steps by rung as the demands table has them: numbers from rung 0 on."""
    return " ".join(map(str, steps_by_rung))


def rung_shares(texts: Iterable[str]) -> list[dict[str, Any]]:
    """Return what each rung carried in a set of analyses.

    Args:
        texts: The column ``steps_by_rung``; an analysis without a step has an empty text.

    Returns:
        By rung: ``rung``, ``attempt`` (in words), ``steps`` and ``steps_share`` (the (sub-)steps
        that converged on it), ``analyses`` and ``analyses_share`` (those whose highest rung it is).
    """
    counts = [[int(count) for count in text.split()] for text in texts]
    highest = [max((rung for rung, n in enumerate(own) if n), default=0) for own in counts]
    steps = [sum(own[rung] for own in counts if rung < len(own)) for rung in range(len(LADDER))]
    return [
        {
            "rung": rung,
            "attempt": _in_words(attempt),
            "steps": steps[rung],
            "steps_share": steps[rung] / max(sum(steps), 1),
            "analyses": highest.count(rung),
            "analyses_share": highest.count(rung) / max(len(counts), 1),
        }
        for rung, attempt in enumerate(LADDER)
    ]


def _in_words(attempt: Attempt) -> str:
    told = str(attempt.algorithm[0])
    if attempt.substeps > 1:
        told += f", {attempt.substeps} sub-steps"
    return f"{told}, test {attempt.tolerance_j:g} J" if attempt.tolerance_j else told
