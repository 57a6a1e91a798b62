"""How a statement of the paper is judged by computed numbers: agrees, disagrees, cannot be told.

A claim with a direction is tested in that direction only. What differs by less than the numerics of
the analyses resolve, or by less than chance explains, cannot be told.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import Final, Literal

from scipy.stats import binomtest, spearmanr

type Outcome = Literal["agrees", "disagrees", "cannot be told"]

# ASSUME a change of a peak smaller than the median error of the default time step says nothing.
RESOLUTION: Final = 0.005
# ASSUME what the paper calls minimal, small or similar is at most 5 %.
SMALL: Final = 0.05
SIGNIFICANCE: Final = 0.05
FEWEST_VALUES: Final = 5  # with fewer, no test of signs or ranks reaches the significance


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What computed numbers say about a statement.

    Attributes:
        reason: Why, with the numbers.
        value: The number that decides, where there is one.
        reference: What it is compared with.
    """

    outcome: Outcome
    reason: str
    value: float | None = None
    reference: float | None = None


def cannot_be_told(
    reason: str, value: float | None = None, reference: float | None = None
) -> Judgement:
    """Return that nothing computed here decides."""
    return Judgement(outcome="cannot be told", reason=reason, value=value, reference=reference)


def decided(
    truth: bool, reason: str, value: float | None = None, reference: float | None = None
) -> Judgement:
    """Return that the statement holds or not."""
    outcome: Outcome = "agrees" if truth else "disagrees"
    return Judgement(outcome=outcome, reason=reason, value=value, reference=reference)


def at_most(what: str, value: float, limit: float) -> Judgement:
    """Judge that a quantity does not exceed a limit."""
    return decided(value <= limit, f"{what}: {value:.4g}, limit {limit:.4g}", value, limit)


def at_least(what: str, value: float, limit: float) -> Judgement:
    """Judge that a quantity reaches a limit."""
    return decided(value >= limit, f"{what}: {value:.4g}, at least {limit:.4g}", value, limit)


def lower(what: str, value: float, reference: float) -> Judgement:
    """Judge that a peak is lower with friction than without.

    Args:
        what: The peak.
        value: With friction.
        reference: Without.
    """
    change = relative_change(value, reference)
    if not isfinite(change):
        return cannot_be_told(f"{what}: nothing without friction", value, reference)
    text = f"{what} changes by {change:+.1%}"
    if abs(change) <= RESOLUTION:
        reason = f"{text}, within the resolution of {RESOLUTION:.1%}"
        return cannot_be_told(reason, value, reference)
    return decided(change < 0.0, text, value, reference)


def reduced_by(
    what: str, value: float, reference: float, limits: tuple[float, float], *, same_record: bool
) -> Judgement:
    """Judge the size of a reduction.

    Args:
        what: The peak.
        value: With friction.
        reference: Without.
        limits: Smallest and largest reduction that the paper's figure covers, as ratios.
        same_record: Whether the motion is the paper's: another need not give its number.
    """
    reduction = -relative_change(value, reference)
    text = f"{what}: reduction of {reduction:.1%}, {limits[0]:.1%} to {limits[1]:.1%} in the paper"
    if not isfinite(reduction):
        return cannot_be_told(f"{what}: nothing without friction", value, reference)
    if reduction <= -RESOLUTION:
        return decided(False, f"{what}: no reduction but {-reduction:+.1%}", value, reference)
    if not same_record:
        return cannot_be_told(f"{text}, under another record", value, reference)
    return decided(limits[0] <= reduction <= limits[1], text, value, reference)


def hardly_changed(what: str, value: float, reference: float) -> Judgement:
    """Judge that friction changes a peak by at most what is called small."""
    change = relative_change(value, reference)
    if not isfinite(change):
        return cannot_be_told(f"{what}: nothing without friction", value, reference)
    reason = f"{what} changes by {change:+.1%}, small is {SMALL:.0%}"
    return decided(abs(change) <= SMALL, reason, value, reference)


def more_often(what: str, count: int, total: int) -> Judgement:
    """Judge that something happens in most of several cases, by the one-sided test of signs."""
    text = f"{what}: {count} of {total}"
    if total < FEWEST_VALUES:
        return cannot_be_told(f"{text}, too few to test", count, total)
    p_more = float(binomtest(count, total, 0.5, alternative="greater").pvalue)
    p_less = float(binomtest(count, total, 0.5, alternative="less").pvalue)
    return _tested(f"{text} (sign test", p_more, p_less, (count, total))


def grows_with(what: str, x: Sequence[float], y: Sequence[float]) -> Judgement:
    """Judge that y grows with x, by Spearman's rank correlation tested against zero."""
    if len(x) < FEWEST_VALUES:
        return cannot_be_told(f"{what}: {len(x)} values, too few to test")
    up, down = (spearmanr(x, y, alternative=side) for side in ("greater", "less"))
    correlation = float(up.statistic)
    if not isfinite(correlation):
        return cannot_be_told(f"{what}: one of the two does not vary")
    text = f"{what}: rank correlation {correlation:+.2f} of {len(x)} (test against zero"
    return _tested(text, float(up.pvalue), float(down.pvalue), (correlation, 0.0))


def _tested(text: str, p_for: float, p_against: float, numbers: tuple[float, float]) -> Judgement:
    """Judge by the p values of the claim and of its opposite."""
    reason = f"{text}, p = {min(p_for, p_against):.2g})"
    if min(p_for, p_against) > SIGNIFICANCE:
        return cannot_be_told(reason, *numbers)
    return decided(p_for < p_against, reason, *numbers)


def relative_change(value: float, reference: float) -> float:
    """Return the change over the reference; of nothing it is infinite, or nan if it stays nothing.

    Both are no numbers to judge by.
    """
    if reference == 0.0:
        return nan if value == 0.0 else inf
    return value / reference - 1.0
