"""The paper's statements: one table of claim, study, computed number and rule of the verdict.

The table paraphrases what sections 2 to 5 of the paper state and a computation can check. A study
computes the number of a statement in each of its cases (`Study.states`); the rule in the row gives
the verdict: agrees, disagrees or cannot be told. A claim with a direction is tested in that
direction only. A change below the resolution of the analyses, or one that chance explains, cannot
be told.

References:
    Rahman and Mackie, Modeling abutment contact-friction using run-time parameter updates.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, isclose, isfinite, isnan, nan
from typing import Any, Final, Literal

from scipy.stats import binomtest, spearmanr

type Outcome = Literal["agrees", "disagrees", "cannot be told"]

# ASSUME a change of a peak smaller than the median error of the default time step says nothing.
RESOLUTION: Final = 0.005
# ASSUME what the paper calls minimal, small or similar is at most 5 %.
SMALL: Final = 0.05
# ASSUME contact is enforced where a penalty lets in at most 3 % of the gap.
CLOSE: Final = 0.03
SIGNIFICANCE: Final = 0.05
FEWEST_VALUES: Final = 5  # with fewer, no test of signs or ranks reaches the significance


@dataclass(frozen=True, slots=True)
class Verdict:
    """Verdict on a statement in one case.

    Attributes:
        outcome: Agrees, disagrees or cannot be told.
        reason: Why, with the numbers.
        value: The number that decides, if there is one.
        reference: What the number is compared with.
    """

    outcome: Outcome
    reason: str
    value: float | None = None
    reference: float | None = None


type Rule = Callable[..., Verdict]
"""Returns the verdict from the numbers of a case."""


def relative_change(value: float, reference: float) -> float:
    """Return the change over the reference; nan or infinite if the reference is zero."""
    if reference == 0.0:
        return nan if value == 0.0 else inf
    return value / reference - 1.0


def _decided(truth: bool, reason: str, value: float, reference: float) -> Verdict:
    if isnan(value) or isnan(reference):
        return Verdict("cannot be told", f"{reason}: not a number", value, reference)
    return Verdict("agrees" if truth else "disagrees", reason, value, reference)


def at_most(limit: float) -> Rule:
    """Return the rule that a value does not exceed a limit."""

    def rule(value: float) -> Verdict:
        return _decided(value <= limit, f"{value:.4g}, limit {limit:.4g}", value, limit)

    return rule


def at_least(limit: float) -> Rule:
    """Return the rule that a value reaches a limit."""

    def rule(value: float) -> Verdict:
        return _decided(value >= limit, f"{value:.4g}, at least {limit:.4g}", value, limit)

    return rule


def greater(factor: float = 1.0) -> Rule:
    """Return the rule that a value exceeds its reference, or a multiple of it."""
    required = "" if factor == 1.0 else f", required factor {factor:g}"

    def rule(value: float, reference: float) -> Verdict:
        reason = f"{value:.4g} against {reference:.4g}{required}"
        return _decided(value > factor * reference, reason, value, reference)

    return rule


def smaller(value: float, reference: float) -> Verdict:
    """Apply the rule that a value is below its reference."""
    return _decided(value < reference, f"{value:.4g} against {reference:.4g}", value, reference)


def equal(value: float, reference: float) -> Verdict:
    """Apply the rule that a value is that of its reference."""
    reason = f"{value:.4g} against {reference:.4g}"
    return _decided(isclose(value, reference), reason, value, reference)


def some_within(low: float, high: float) -> Rule:
    """Return the rule that one of several values, given by name, lies within limits."""

    def rule(values: Mapping[float, float]) -> Verdict:
        listed = ", ".join(f"{value:.2f} at {name:g}" for name, value in values.items())
        within = [value for value in values.values() if low <= value <= high]
        first = next(iter(within or values.values()))
        return _decided(bool(within), f"{listed}; {low:g} to {high:g} in the paper", first, high)

    return rule


def falls_to(limit: float) -> Rule:
    """Return the rule that a sequence falls at every step and ends at or below a limit."""

    def rule(values: Sequence[float]) -> Verdict:
        falls = all(after < before for before, after in pairwise(values))
        reason = f"from {values[0]:.3g} to {values[-1]:.3g}, limit {limit:g}"
        return _decided(falls and values[-1] <= limit, reason, values[-1], limit)

    return rule


def lower(value: float, reference: float) -> Verdict:
    """Apply the rule that a peak with friction is below the peak without (the reference)."""
    change = relative_change(value, reference)
    if not isfinite(change):
        return Verdict("cannot be told", "zero without friction", value, reference)
    if abs(change) <= RESOLUTION:
        reason = f"changes by {change:+.1%}, within the resolution of {RESOLUTION:.1%}"
        return Verdict("cannot be told", reason, value, reference)
    return _decided(change < 0.0, f"changes by {change:+.1%}", value, reference)


def reduced_by(low: float, high: float) -> Rule:
    """Return the rule that friction reduces a peak by a share within limits.

    Under another record than the paper's (`same_record` false) the size cannot be told.
    """

    def rule(value: float, reference: float, *, same_record: bool) -> Verdict:
        change = relative_change(value, reference)
        reason = f"changes by {change:+.1%}, reduction of {low:.1%} to {high:.1%} in the paper"
        if not isfinite(change):
            return Verdict("cannot be told", "zero without friction", value, reference)
        if change >= RESOLUTION:
            return _decided(False, reason, value, reference)
        if not same_record:
            return Verdict("cannot be told", f"{reason}, other record", value, reference)
        return _decided(low <= -change <= high, reason, value, reference)

    return rule


def hardly_changed(value: float, reference: float) -> Verdict:
    """Apply the rule that friction changes a peak by at most what the paper calls small."""
    change = relative_change(value, reference)
    if not isfinite(change):
        return Verdict("cannot be told", "zero without friction", value, reference)
    reason = f"changes by {change:+.1%}, small is {SMALL:.0%}"
    return _decided(abs(change) <= SMALL, reason, value, reference)


def more_often(count: int, total: int) -> Verdict:
    """Apply the rule that something happens in most of several cases, by a one-sided sign test."""
    if total < FEWEST_VALUES:
        return Verdict("cannot be told", f"{count} of {total}, too few to test", count, total)
    p_for, p_against = (
        float(binomtest(count, total, 0.5, alternative=side).pvalue) for side in ("greater", "less")
    )
    return _tested(f"{count} of {total}, sign test", p_for, p_against, (count, total))


def grows_with(x: Sequence[float], y: Sequence[float]) -> Verdict:
    """Apply the rule that y grows with x, by Spearman's rank correlation tested against zero."""
    if len(x) < FEWEST_VALUES:
        return Verdict("cannot be told", f"{len(x)} values, too few to test")
    up, down = (spearmanr(x, y, alternative=side) for side in ("greater", "less"))
    correlation = float(up.statistic)
    if not isfinite(correlation):
        return Verdict("cannot be told", "one of the two does not vary")
    text = f"rank correlation {correlation:+.2f} of {len(x)}, test against zero"
    return _tested(text, float(up.pvalue), float(down.pvalue), (correlation, 0.0))


def _tested(text: str, p_for: float, p_against: float, numbers: tuple[float, float]) -> Verdict:
    """Return the verdict by the p values of the claim and of its opposite."""
    reason = f"{text}: p = {min(p_for, p_against):.2g}"
    if min(p_for, p_against) > SIGNIFICANCE:
        return Verdict("cannot be told", reason, *numbers)
    return _decided(p_for < p_against, reason, *numbers)


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of the paper. A claim that is judged by two numbers has two rows.

    Attributes:
        place: Section and figure.
        claim: What is stated, in our words.
        study: Study that judges it (`skewbridge verify STUDY`); others may add cases.
        number: What the study computes for the verdict.
        rule: Verdict from that number; a text is the reason why no number decides.
    """

    place: str
    claim: str
    study: str
    number: str
    rule: Rule | str

    def verdict(self, *numbers: Any, **conditions: bool) -> Verdict:
        """Return the verdict from the numbers of a case; the reason names the number."""
        if isinstance(self.rule, str):
            listed = [f"{self.number} {number:.2g}" for number in numbers[:1]]
            return Verdict("cannot be told", "; ".join([*listed, self.rule]), *numbers)
        found = self.rule(*numbers, **conditions)
        return replace(found, reason=f"{self.number}: {found.reason}")


_NO_TEST_DATA: Final = (
    "histories, masses, bearings and table motion of the tests are not public; over their "
    "plausible range the rotation varies four- to fivefold"
)
_RMS_FORCES: Final = "RMS error of the forces over the friction limit"
_RMS_FRICTION: Final = "RMS error of the friction over the limit"
# source: the paper, section 5: 2 to 3 %, as rounded to whole percents
_PAPER_REDUCTION: Final = (0.015, 0.035)

STATEMENTS: Final[Mapping[str, Statement]] = {
    "unit without gap": Statement(
        "section 2.1, figure 1",
        "without an initial gap the unit is a dry frictional contact between two nodes",
        "fig1",
        _RMS_FORCES,
        at_most(0.01),
    ),
    "unit behind a gap": Statement(
        "section 2.1, figure 1",
        "behind an initial gap it contacts and slides like a node on a line",
        "fig1",
        _RMS_FORCES,
        at_most(0.01),
    ),
    "existing parts": Statement(
        "section 2.1",
        "existing elements and materials of OpenSees suffice, without new source code",
        "fig1",
        "loops of one unit that OpenSees ran as released",
        at_least(6),
    ),
    "elastic springs too": Statement(
        "section 2.1",
        "elastic springs alone solve it too, if the script tracks the point of sticking",
        "fig3",
        _RMS_FRICTION,
        at_most(SMALL),
    ),
    "penalties enforce": Statement(
        "section 2.1",
        "large stiffnesses enforce contact and sticking",
        "fig4",
        "penetration over the gap",
        at_most(CLOSE),
    ),
    "limit in every direction": Statement(
        "section 2.2, figure 2",
        "friction reaches its limit and no more, whatever the direction in the plane",
        "fig3",
        "largest force over the limit",
        at_most(1.01),
    ),
    "components are coupled": Statement(
        "section 2.2, figures 2 and 3",
        "the direction taken from the point of sticking couples the two components",
        "fig3",
        _RMS_FRICTION,
        at_most(SMALL),
    ),
    "closing decides": Statement(
        "section 2.2, figure 3",
        "the square wave decides where there is contact, and with it friction",
        "fig3",
        "friction while open (N)",
        at_most(0.0),
    ),
    "node to line": Statement(
        "section 2.3, figure 4",
        "the unit behaves as a node against a line through the perpendicular distance",
        "fig4",
        "RMS difference of the normal motion from the rigid particle, over the gap",
        at_most(CLOSE),
    ),
    "bounded by the lines": Statement(
        "section 2.3, figure 4",
        "normal displacements stay within the perpendicular distance of both lines",
        "fig4",
        "normal motion beyond the gap, over the gap",
        at_most(CLOSE),
    ),
    "depends on plan and friction": Statement(
        "section 3.1",
        "rotations after impact depend on skew, plan geometry and friction",
        "fig5-6",
        "change of the peak rotation x length over the scale",
        at_least(SMALL),
    ),
    "coupling at low frequency": Statement(
        "section 3.1",
        "the coupling is strongest at the low frequencies of the spectrum",
        "fig5-6",
        "response spectra",
        "a statement on spectra of Dimitrakopoulos (2011); the study has one period of the deck",
    ),
    "deck agrees": Statement(
        "section 3.1, figure 5",
        "displacements of the mass centre agree with the complementarity solution",
        "fig5-6",
        "RMS difference over the rigid peak (over the scale where it is zero)",
        at_most(2 * SMALL),
    ),
    "differences grow": Statement(
        "section 3.1, figure 6",
        "small differences in phase and amplitude grow with the number of impacts",
        "fig5-6",
        "RMS difference over that of the motion, after half of the impacts against before",
        greater(),
    ),
    "penalty converges": Statement(
        "section 3.1",
        "they come from the finite penalty and the missing restitution",
        "fig5-6",
        "RMS difference over the scale as the damped penalty stiffens",
        falls_to(0.01),
    ),
    "penalty is the cause": Statement(
        "section 3.1",
        "they come from the finite penalty and the missing restitution",
        "fig5-6",
        "stiff damped penalty, worst difference of the three peaks over the scale",
        at_most(2 * SMALL),
    ),
    # The paper gives no mass, so its step over the contact period is unknown: some step suffices.
    "restitution found": Statement(
        "section 3.1",
        "the restitution of the numerical model lies between 0.45 and 0.71",
        "fig5-6",
        "median restitution by step x contact frequency",
        some_within(0.45, 0.71),
    ),
    "restitution falls": Statement(
        "section 3.1",
        "it is lower at high approach speeds than at low ones",
        "fig5-6",
        "loss at impact against approach speed",
        grows_with,
    ),
    "damper helps": Statement(
        "section 3.1",
        "a damper brings the penalty closer to the complementarity solution",
        "fig5-6",
        "worst difference of the three peaks over the scale, damped against elastic penalty",
        smaller,
    ),
    "skew deck rotates": Statement(
        "section 3.2",
        "an obtuse corner that hits its wall turns the skewed deck",
        "fig7-8",
        "peak rotation (mrad)",
        at_least(0.1),
    ),
    "skew bridge rotates": Statement(
        "section 3.2",
        "an obtuse corner that hits its wall turns the skewed deck",
        "ladder",
        "peak rotation in mrad, with skew against without",
        greater(factor=2.0),
    ),
    "acute corner moves away": Statement(
        "section 3.2",
        "acute corners move far from their walls, more than obtuse ones",
        "fig7-8",
        "largest opening beyond the gap in mm, acute against obtuse corner",
        greater(),
    ),
    "acute corner leads": Statement(
        "section 3.2",
        "acute corners move far from their walls, more than obtuse ones",
        "ladder",
        "unseating in m, acute corner against worst corner",
        equal,
    ),
    "skew needs longer seats": Statement(
        "section 3.2",
        "skewed bridges need longer seats than straight ones",
        "ladder",
        "unseating in m, with skew against without",
        greater(factor=1.0 + RESOLUTION),
    ),
    "test phasing": Statement(
        "section 3.2, figure 7",
        "normal deformations are close to the tests in phase and amplitude",
        "fig7-8",
        "histories of the tests",
        _NO_TEST_DATA,
    ),
    "test coherence": Statement(
        "section 3.2, figure 7",
        "right after a contact the coherence with the tests is partly lost",
        "fig7-8",
        "histories of the tests",
        _NO_TEST_DATA,
    ),
    "test forces": Statement(
        "section 3.2, figure 8",
        "opposite corners are ordered as the load cells, forces 50 to 100 % off",
        "fig7-8",
        "forces of the tests",
        _NO_TEST_DATA,
    ),
    "longer contact": Statement(
        "section 3.2, figure 8",
        "contacts last longer than in the deck of figure 5",
        "fig7-8",
        "time of contact over that of figure 5, by the root of mass over penalty",
        "by the masses assumed here; the paper gives neither",
    ),
    "static push": Statement(
        "section 4",
        "pushed along one axis without skew, friction does not contribute",
        "fig10",
        "largest change of the force over its peak",
        at_most(1e-6),
    ),
    "longitudinal hardly changes": Statement(
        "section 4, figure 10",
        "friction has a minimal effect on the longitudinal response",
        "fig10",
        "longitudinal peak",
        hardly_changed,
    ),
    # ASSUME the paper's stick-slip events are at least ten changes
    "keys stick and slip": Statement(
        "section 4, figure 10",
        "longitudinal motion makes the shear keys stick and slip",
        "fig10",
        "changes between sticking and slipping",
        at_least(10),
    ),
    # ASSUME high frequency is above 5 Hz, above the modes of the deck
    "fast vibration": Statement(
        "section 4, figure 10",
        "this shows as small fast vibrations in the longitudinal loops",
        "fig10",
        "RMS of the longitudinal force above 5 Hz in kN, with friction against without",
        greater(),
    ),
    "transverse differs more": Statement(
        "section 4, figure 10",
        "friction changes the transverse response more than the longitudinal one",
        "fig10",
        "relative change by friction, transverse against longitudinal",
        greater(),
    ),
    "backwall makes it": Statement(
        "section 4, figure 10",
        "the transverse difference is friction along the backwall",
        "fig10",
        "RMS change of the transverse displacement, friction at walls only against keys only",
        greater(),
    ),
    "several contacts": Statement(
        "section 4, figure 10",
        "friction acts in several contacts as the longitudinal gap closes",
        "fig10",
        "closures of backwall contacts",
        at_least(2),
    ),
    "transverse peak": Statement(
        "section 4, figure 10",
        "friction lowers the transverse peak",
        "fig10",
        "transverse peak",
        lower,
    ),
    "transverse cycles": Statement(
        "section 4, figure 10",
        "friction lowers the transverse peaks of the cycles in contact",
        "fig10",
        "half cycles in contact with a lower peak",
        more_often,
    ),
    "bridge cycles": Statement(
        "section 5, figure 11",
        "friction lowers the displacement peaks of the cycles in contact",
        "fig11-12",
        "half cycles in contact with a lower peak",
        more_often,
    ),
    "bridge transverse loops": Statement(
        "section 5, figure 12",
        "without skew, friction shows most in the transverse loops of the abutments",
        "fig11-12",
        "RMS change of the abutment force, transverse against longitudinal",
        greater(),
    ),
    # ASSUME a history is coupled if it changes by more than the largest error of the default step
    "axes are coupled": Statement(
        "section 5, figures 11 and 12",
        "friction couples the longitudinal and transverse response even without skew",
        "fig11-12",
        "RMS change of the displacement over its RMS",
        at_least(0.02),
    ),
    "displacement is reduced": Statement(
        "section 5, figure 11",
        "friction reduces the peak displacement",
        "fig11-12",
        "peak displacement",
        lower,
    ),
    "displacement by 2 to 3 percent": Statement(
        "section 5, figure 11",
        "by only 2 to 3 percent",
        "fig11-12",
        "peak displacement",
        reduced_by(*_PAPER_REDUCTION),
    ),
    "shear is reduced": Statement(
        "section 5",
        "friction reduces the column shear",
        "fig11-12",
        "peak column shear",
        lower,
    ),
    "shear by as much": Statement(
        "section 5",
        "by about as much",
        "fig11-12",
        "difference between the reductions of shear and displacement",
        at_most(_PAPER_REDUCTION[0]),
    ),
    "in phase differs most": Statement(
        "section 5, figures 11 and 12",
        "it changes most the cycles whose longitudinal and transverse peaks coincide",
        "fig11-12",
        "size of the change against how much both peaks coincide",
        grows_with,
    ),
}


def statements_of(study: str) -> dict[str, Statement]:
    """Return the statements that a study has to judge."""
    return {key: found for key, found in STATEMENTS.items() if found.study == study}
