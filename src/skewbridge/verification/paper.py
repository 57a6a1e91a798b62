"""What the paper states in sections 2 to 5 and can be checked, paraphrased: one table.

Which study judges a statement, in how many cases, is said by the study (`Study.states`); what no
computation here can tell has its reason beside it. A disagreement that stands is a result.

References:
    Rahman and Mackie, Modeling abutment contact-friction using run-time parameter updates.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """One statement of the paper.

    Attributes:
        place: Section and figure.
        claim: What is stated, in our words.
        study: The study that judges it (others may add cases).
        open_because: Why nothing computed here can tell; empty where the study judges.
    """

    place: str
    claim: str
    study: str
    open_because: str = ""


_NO_TEST_DATA: Final = (
    "histories, masses, bearings and table motion of the tests are not public; over their "
    "plausible range the rotation varies four- to fivefold"
)

STATEMENTS: Final[Mapping[str, Statement]] = {
    "unit without gap": Statement(
        place="section 2.1, figure 1",
        claim="without an initial gap the unit is a dry frictional contact between two nodes",
        study="fig1",
    ),
    "unit behind a gap": Statement(
        place="section 2.1, figure 1",
        claim="behind an initial gap it contacts and slides like a node on a line",
        study="fig1",
    ),
    "existing parts": Statement(
        place="section 2.1",
        claim="existing elements and materials of OpenSees suffice, without new source code",
        study="fig1",
    ),
    "elastic springs too": Statement(
        place="section 2.1",
        claim="elastic springs alone solve it too, if the script tracks the point of sticking",
        study="fig3",
    ),
    "penalties enforce": Statement(
        place="section 2.1",
        claim="large stiffnesses enforce contact and sticking",
        study="fig4",
    ),
    "limit in every direction": Statement(
        place="section 2.2, figure 2",
        claim="friction reaches its limit and no more, whatever the direction in the plane",
        study="fig3",
    ),
    "components are coupled": Statement(
        place="section 2.2, figures 2 and 3",
        claim="the direction taken from the point of sticking couples the two components",
        study="fig3",
    ),
    "closing decides": Statement(
        place="section 2.2, figure 3",
        claim="the square wave decides where there is contact, and with it friction",
        study="fig3",
    ),
    "node to line": Statement(
        place="section 2.3, figure 4",
        claim="the unit behaves as a node against a line through the perpendicular distance",
        study="fig4",
    ),
    "bounded by the lines": Statement(
        place="section 2.3, figure 4",
        claim="normal displacements stay within the perpendicular distance of both lines",
        study="fig4",
    ),
    "depends on plan and friction": Statement(
        place="section 3.1",
        claim="rotations after impact depend on skew, plan geometry and friction",
        study="fig5-6",
    ),
    "coupling at low frequency": Statement(
        place="section 3.1",
        claim="the coupling is strongest at the low frequencies of the spectrum",
        study="fig5-6",
        open_because="a statement on response spectra of Dimitrakopoulos (2011); the study has "
        "one period of the deck",
    ),
    "deck agrees": Statement(
        place="section 3.1, figure 5",
        claim="displacements of the mass centre agree with the complementarity solution",
        study="fig5-6",
    ),
    "differences grow": Statement(
        place="section 3.1, figure 6",
        claim="small differences in phase and amplitude grow with the number of impacts",
        study="fig5-6",
    ),
    "penalty is the cause": Statement(
        place="section 3.1",
        claim="they come from the finite penalty and the missing restitution",
        study="fig5-6",
    ),
    "restitution found": Statement(
        place="section 3.1",
        claim="the restitution of the numerical model lies between 0.45 and 0.71",
        study="fig5-6",
    ),
    "restitution falls": Statement(
        place="section 3.1",
        claim="it is lower at high approach speeds than at low ones",
        study="fig5-6",
    ),
    "damper helps": Statement(
        place="section 3.1",
        claim="a damper brings the penalty closer to the complementarity solution",
        study="fig5-6",
    ),
    "skew deck rotates": Statement(
        place="section 3.2",
        claim="an obtuse corner that hits its wall turns the skewed deck",
        study="fig7-8",
    ),
    "acute corner moves away": Statement(
        place="section 3.2",
        claim="acute corners move far from their walls, more than obtuse ones",
        study="fig7-8",
    ),
    "skew needs longer seats": Statement(
        place="section 3.2",
        claim="skewed bridges need longer seats than straight ones",
        study="ladder",
    ),
    "test phasing": Statement(
        place="section 3.2, figure 7",
        claim="normal deformations are close to the tests in phase and amplitude",
        study="fig7-8",
        open_because=_NO_TEST_DATA,
    ),
    "test coherence": Statement(
        place="section 3.2, figure 7",
        claim="right after a contact the coherence with the tests is partly lost",
        study="fig7-8",
        open_because=_NO_TEST_DATA,
    ),
    "test forces": Statement(
        place="section 3.2, figure 8",
        claim="opposite corners are ordered as the load cells, forces 50 to 100 % off",
        study="fig7-8",
        open_because=_NO_TEST_DATA,
    ),
    "longer contact": Statement(
        place="section 3.2, figure 8",
        claim="contacts last longer than in the deck of figure 5",
        study="fig7-8",
    ),
    "static push": Statement(
        place="section 4",
        claim="pushed along one axis without skew, friction does not contribute",
        study="fig10",
    ),
    "longitudinal hardly changes": Statement(
        place="section 4, figure 10",
        claim="friction has a minimal effect on the longitudinal response",
        study="fig10",
    ),
    "keys stick and slip": Statement(
        place="section 4, figure 10",
        claim="longitudinal motion makes the shear keys stick and slip",
        study="fig10",
    ),
    "fast vibration": Statement(
        place="section 4, figure 10",
        claim="this shows as small fast vibrations in the longitudinal loops",
        study="fig10",
    ),
    "transverse differs more": Statement(
        place="section 4, figure 10",
        claim="friction changes the transverse response more than the longitudinal one",
        study="fig10",
    ),
    "backwall makes it": Statement(
        place="section 4, figure 10",
        claim="the transverse difference is friction along the backwall",
        study="fig10",
    ),
    "several contacts": Statement(
        place="section 4, figure 10",
        claim="friction acts in several contacts as the longitudinal gap closes",
        study="fig10",
    ),
    "transverse peak": Statement(
        place="section 4, figure 10",
        claim="friction lowers the transverse peak",
        study="fig10",
    ),
    "transverse cycles": Statement(
        place="section 4, figure 10",
        claim="friction lowers the transverse peaks of the cycles in contact",
        study="fig10",
    ),
    "bridge cycles": Statement(
        place="section 5, figure 11",
        claim="friction lowers the displacement peaks of the cycles in contact",
        study="fig11-12",
    ),
    "bridge transverse loops": Statement(
        place="section 5, figure 12",
        claim="without skew, friction shows most in the transverse loops of the abutments",
        study="fig11-12",
    ),
    "axes are coupled": Statement(
        place="section 5, figures 11 and 12",
        claim="friction couples the longitudinal and transverse response even without skew",
        study="fig11-12",
    ),
    "displacement is reduced": Statement(
        place="section 5, figure 11",
        claim="friction reduces the peak displacement",
        study="fig11-12",
    ),
    "displacement by 2 to 3 percent": Statement(
        place="section 5, figure 11",
        claim="by only 2 to 3 percent",
        study="fig11-12",
    ),
    "shear is reduced": Statement(
        place="section 5",
        claim="friction reduces the column shear",
        study="fig11-12",
    ),
    "shear by as much": Statement(
        place="section 5",
        claim="by about as much",
        study="fig11-12",
    ),
    "in phase differs most": Statement(
        place="section 5, figures 11 and 12",
        claim="it changes most the cycles whose longitudinal and transverse peaks coincide",
        study="fig11-12",
    ),
}


def statements_of(study: str) -> dict[str, Statement]:
    """Return the statements that a study has to judge."""
    return {key: found for key, found in STATEMENTS.items() if found.study == study}
