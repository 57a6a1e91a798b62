"""Verdicts on the paper's statements: the table `statements.csv` and the rules that it names.

The table paraphrases the statements of sections 2 to 5 of the paper that a computation can check.
A row has a claim, a study, a number and a rule; a claim that two numbers judge has two rows. The
study computes the number in each of its cases (`Study.states`); the rule gives the verdict. A claim
with a direction is tested in that direction only. Cases under a record are judged in several runs
(docs/theory/verification.md).

The table assumes these limits: small means at most 5 %; a penalty enforces contact if it penetrates
by at most 3 % of the gap; stick-slip means at least ten changes; a history is coupled if it changes
by more than 2 %, the largest error of the default time step; reductions of 2 to 3 % are rounded to
whole percents. The paper gives no mass, so the ratio of its step to the period of a contact is
unknown: it is enough if one of several steps shows the paper's restitution.

References:
    Rahman and Mackie, Modeling abutment contact-friction using run-time parameter updates.
"""

import csv
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from math import inf, isclose, isfinite, isnan, nan
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

type Outcome = Literal["agrees", "disagrees", "undecidable"]

# ASSUME a change of a peak within the median error of the default time step is not significant.
RESOLUTION: Final = 0.005
# ASSUME minimal, small and similar in the paper mean at most 5 %.
SMALL: Final = 0.05
SIGNIFICANCE: Final = 0.05
FEWEST_RUNS: Final = 7
FEWEST_VALUES: Final = 5  # with fewer values sign and rank tests cannot be significant


class Verdict(NamedTuple):
    """Verdict on a statement in one case; if from several runs, with the numbers at scale 1."""

    outcome: Outcome
    reason: str
    value: float | None = None  # the number that decides, if there is one
    reference: float | None = None
    scales: tuple[int, int] = (0, 0)  # runs with the scaled record, and how many of them agree
    motions: tuple[int, int] = (0, 0)  # the same for runs with other motions


class Run(NamedTuple):
    """One run of a case: the record of the study at a scale, or one of the other motions."""

    name: str
    scale: float | None = None  # None for other motions


NOMINAL: Final = Run("scale 1", 1.0)


def over_runs(verdicts: Mapping[Run | None, Verdict | None]) -> Verdict:
    """Return the verdict of a case from its runs; a run that does not meet the premise has None.

    At least `FEWEST_RUNS` runs must meet it and 90 % of them agree (or disagree); the key None is a
    verdict that is not from a run.
    """
    if only := verdicts.get(None):
        return only
    judged_runs = {run: verdict for run, verdict in verdicts.items() if run and verdict}
    by_kind: tuple[list[Outcome], list[Outcome]] = [], []
    for run, verdict in judged_runs.items():
        by_kind[run.scale is None].append(verdict.outcome)
    scales, motions = ((len(kind), kind.count("agrees")) for kind in by_kind)
    counts = ((scales, "scales"), (motions, "other motions"))
    text = ", ".join(f"{agree} of {total} {name}" for (total, agree), name in counts if total)
    nominal = judged_runs.get(NOMINAL, Verdict("undecidable", ""))
    at_scale_1 = f"; at scale 1: {nominal.reason}" if nominal.reason else ""
    outcome: Outcome = "undecidable"
    if len(judged_runs) < FEWEST_RUNS:
        reason = f"only {len(judged_runs)} of {len(verdicts)} runs meet the premise"
        reason += f"; agrees in {text}{at_scale_1}" if text else ""
    else:
        outcomes = by_kind[0] + by_kind[1]
        if (majority := max(outcomes, key=outcomes.count)) != "undecidable":
            outcome = majority if outcomes.count(majority) >= 0.9 * len(outcomes) else outcome
        reason = f"agrees in {text}, disagrees in {outcomes.count('disagrees')}{at_scale_1}"
    return Verdict(outcome, reason, nominal.value, nominal.reference, scales, motions)


def _decided(truth: bool, reason: str, value: float, reference: float) -> Verdict:
    if isnan(value) or isnan(reference):
        return Verdict("undecidable", f"{reason}: not a number", value, reference)
    return Verdict("agrees" if truth else "disagrees", reason, value, reference)


# The rules take the numbers of a case, then the limits of the table.


def _comparison(holds: Callable[[float, float], bool], words: str) -> Callable[..., Verdict]:
    """Return a rule that compares a value with a limit, or with a multiple of a second value."""

    def judge(value: float, reference: float, factor: float = 1.0) -> Verdict:
        required = "" if factor == 1.0 else f", required factor {factor:g}"
        reason = f"{value:.4g}{words} {reference:.4g}{required}"
        return _decided(holds(value, factor * reference), reason, value, reference)

    return judge


def some_within(values: Mapping[float, float], low: float, high: float) -> Verdict:
    """Judge whether at least one of several values (keyed by name) lies within limits."""
    values_text = ", ".join(f"{value:.2f} at {name:g}" for name, value in values.items())
    within = [value for value in values.values() if low <= value <= high]
    first = next(iter(within or values.values()))
    return _decided(bool(within), f"{values_text}; {low:g} to {high:g} in the paper", first, high)


def falls_to(values: Sequence[float], limit: float) -> Verdict:
    """Judge whether a sequence decreases at every step and ends at or below a limit."""
    falls = all(after < before for before, after in pairwise(values))
    reason = f"from {values[0]:.3g} to {values[-1]:.3g}, limit {limit:g}"
    return _decided(falls and values[-1] <= limit, reason, values[-1], limit)


def relative_change(value: float, reference: float) -> float:
    """Return value / reference - 1. For a zero reference: nan if the value is zero, else inf."""
    if reference == 0.0:
        return nan if value == 0.0 else inf
    return value / reference - 1.0


def _change(
    value: float, reference: float, low: float, high: float, words: str = "", least: float = 0.0
) -> Verdict:
    """Judge whether the relative change of a peak by friction is within limits.

    The reference is the peak without friction; changes below `least` are undecidable.
    """
    change = relative_change(value, reference)
    reason = f"changes by {change:+.1%}{words}"
    if not isfinite(change):
        return Verdict("undecidable", "the peak without friction is zero", value, reference)
    if abs(change) < least:
        text = f"{reason}, within the resolution of {least:.1%}"
        return Verdict("undecidable", text, value, reference)
    return _decided(low <= change <= high, reason, value, reference)


def reduced_by(
    value: float, reference: float, low: float, high: float, *, same_record: bool
) -> Verdict:
    """Judge whether friction reduces a peak by a fraction within limits.

    Under a record that is not the paper's (`same_record` false), a reduction is undecidable.
    """
    words = f", reduction of {low:.1%} to {high:.1%} in the paper"
    result = _change(value, reference, -high, -low, words)
    if same_record or not -1.0 <= relative_change(value, reference) < RESOLUTION:
        return result
    return result._replace(outcome="undecidable", reason=f"{result.reason}, not the paper's record")


def more_often(count: int, total: int) -> Verdict:
    """Judge by one-sided sign tests whether more cases agree than disagree."""
    from scipy.stats import binomtest  # imported here: the contact checks do not need it

    if total < FEWEST_VALUES:
        return Verdict("undecidable", f"{count} of {total} agree, too few to test", count, total)
    tests = [binomtest(count, total, 0.5, alternative=side) for side in ("greater", "less")]
    p_for, p_against = (float(test.pvalue) for test in tests)
    return _tested(f"{count} of {total} cases agree, sign test", p_for, p_against, (count, total))


def grows_with(x: Sequence[float], y: Sequence[float]) -> Verdict:
    """Judge whether ``y`` grows with ``x``, by testing Spearman's rank correlation against zero."""
    from scipy.stats import spearmanr

    if len(x) < FEWEST_VALUES:
        return Verdict("undecidable", f"{len(x)} values are too few to test")
    rising, falling = (spearmanr(x, y, alternative=side) for side in ("greater", "less"))
    correlation = float(rising.statistic)
    if not isfinite(correlation):
        return Verdict("undecidable", "one of the two quantities is constant")
    text = f"rank correlation {correlation:+.2f} of {len(x)} values, test against zero"
    return _tested(text, float(rising.pvalue), float(falling.pvalue), (correlation, 0.0))


def _tested(text: str, p_for: float, p_against: float, numbers: tuple[float, float]) -> Verdict:
    reason = f"{text}: p = {min(p_for, p_against):.2g}"
    if min(p_for, p_against) > SIGNIFICANCE:
        return Verdict("undecidable", reason, *numbers)
    return _decided(p_for < p_against, reason, *numbers)


#: Rules keyed by their names in the table.
RULES: Final[Mapping[str, Callable[..., Verdict]]] = {
    "at most": _comparison(operator.le, ", limit"),
    "at least": _comparison(operator.ge, ", at least"),
    "greater": _comparison(operator.gt, " against"),
    "smaller": _comparison(operator.lt, " against"),
    "equal": _comparison(isclose, " against"),
    "some within": some_within,
    "falls to": falls_to,
    "lower": partial(_change, low=-inf, high=0.0, least=RESOLUTION),
    "reduced by": reduced_by,
    "hardly changed": partial(
        _change, low=-SMALL, high=SMALL, words=f", small means at most {SMALL:.0%}"
    ),
    "more often": more_often,
    "grows": grows_with,
}


class Statement(NamedTuple):
    """One paraphrased statement of the paper, which is a row of `statements.csv`.

    The rule judges the number with the limits; without a rule, `open_because` states why not.
    """

    place: str
    claim: str
    study: str
    number: str
    rule: str
    limits: tuple[float, ...]
    open_because: str

    def verdict(self, *numbers: Any, **conditions: bool) -> Verdict:
        """Return the verdict for the numbers of a case; its reason starts with the quantity."""
        if self.open_because:
            numbers_text = [f"{self.number} {number:.2g}" for number in numbers[:1]]
            return Verdict("undecidable", "; ".join([*numbers_text, self.open_because]), *numbers)
        verdict = RULES[self.rule](*numbers, *self.limits, **conditions)
        return verdict._replace(reason=f"{self.number}: {verdict.reason}")


def records_in(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV table of this package."""
    return list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


STATEMENTS: Final[Mapping[str, Statement]] = {
    row.pop("statement"): Statement(limits=(*map(float, row.pop("limits").split()),), **row)
    for row in records_in(Path(__file__).with_name("statements.csv"))
}
