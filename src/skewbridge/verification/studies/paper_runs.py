"""Records and variants of the paper's bridge studies.

Recorded motions cannot be distributed with the package. The studies search for them in `motions/`
of the working folder and in the folders listed in the environment variable `SKEWBRIDGE_RECORDS`. If
a record is missing, every figure names the motion that replaces it.
"""

import os
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final, Self

from skewbridge.bridge.library import load_structure
from skewbridge.motions import read
from skewbridge.motions.folder import INDEX_NAME, read_index
from skewbridge.motions.formats import Stated
from skewbridge.motions.intensity import motion_measures, orbit_rotd50
from skewbridge.motions.levels import LEVEL_MEASURE, LEVEL_RANGE_G, block_factors
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import read_entry
from skewbridge.study.folder import starter_files
from skewbridge.units import G_MPS2
from skewbridge.variant.variant import Variant
from skewbridge.verification.statements import NOMINAL, Run

FOLDERS_VARIABLE: Final = "SKEWBRIDGE_RECORDS"

FRICTION_PCT: Final = 50  # source: the paper, section 4
GAP_MM: Final = 51  # source: the paper, section 4
#: Scale factors of the record of a study: within 5 %, the sign of many effects changes.
SCALES: Final = (0.95, 0.967, 0.983, 1.0, 1.017, 1.033, 1.05)
#: Number of other motions that judge a statement if the paper's record is missing.
OTHER_MOTIONS: Final = 5
#: Records of the paper: identifier, patterns of the longitudinal file (the first) and of the
#: transverse file (the others), PGA (RotD50) in g.
_RECORDS: Final[dict[str, tuple[str, tuple[str, ...], float]]] = {
    # source: PEER NGA-West2 flatfile, RSN 1087 (Northridge 1994, Tarzana)
    "Tarzana": ("TAR", ("*TAR090*", "*TAR360*", "*TAR000*"), 1.6440),
    "WAHO": ("RSN811_WAHO", ("*WAH090*", "*WAH000*"), read.WAHO_PGA_ROTD50_G),
    # source: PEER NGA-West2, RSN 6 (Imperial Valley 1940, El Centro): geometric mean of the two
    # components, 0.2808 and 0.2107 g
    "El Centro": ("RSN6_ELC", ("*ELC180*", "*ELC270*"), 0.2432),
}


@dataclass(frozen=True, slots=True)
class PaperMotion:
    """A scaled motion with a label for figures; component 1 is longitudinal.

    `run` has the scale of the study's motion, or the name of an additional motion. Additional
    motions are scaled to a PGA (RotD50) of `other_pga_g`.
    """

    motion: GroundMotion
    label: str
    other_pga_g: float
    is_paper_record: bool = False
    run: Run = NOMINAL

    @property
    def stand_in(self) -> str:
        """Suffix of case names: empty for the paper's record, else the label of the stand-in."""
        return "" if self.is_paper_record else f" ({self.label})"

    @property
    def is_nominal(self) -> bool:
        """Whether this is the motion of the study at scale 1."""
        return self.run.scale == 1.0

    def runs(self) -> list[Self]:
        """Return this motion at all `SCALES`, and more motions of the suite if it is a stand-in."""
        names = {scale: Run(f"scale {scale:g}", scale) for scale in SCALES}
        scaled = [replace(self, motion=self.motion.scaled(s), run=run) for s, run in names.items()]
        if self.is_paper_record:
            return scaled
        strongest = strongest_motions(OTHER_MOTIONS + 1, self.other_pga_g)
        others = [motion for motion in strongest if motion.motion_id != self.motion.motion_id]
        scaled_to = f"at a PGA of {self.other_pga_g:.2f} g"
        return scaled + [
            replace(self, motion=m, label=f"{m.motion_id} {scaled_to}", run=Run(m.motion_id))
            for m in others[:OTHER_MOTIONS]
        ]


def waho() -> PaperMotion:
    """Return WAHO (090 longitudinal, 000 transverse), its surrogate, or a synthetic pair."""
    # The package's motions have no pulse: at the PGA of WAHO they do not close the gaps of OSB1, so
    # three times that PGA is needed to test statements on contact.
    motion_of_paper = paper_record("WAHO", factor=3.0)
    north, east = (_find(name) for name in read.SURROGATE_FILES)
    if motion_of_paper.is_paper_record or not (north and east):
        return motion_of_paper
    motion = read.read_motion(east, north, Stated(unit="g"), motion_id=read.SURROGATE_ID)
    label = f"surrogate for WAHO: Capitola x {read.SURROGATE_FACTOR:g}"
    return replace(motion_of_paper, motion=motion.scaled(read.SURROGATE_FACTOR), label=label)


def _find(*patterns: str) -> Path | None:
    """Return the first record found, by pattern, folder and name; None if no file matches."""
    listed = [part for part in os.environ.get(FOLDERS_VARIABLE, "").split(os.pathsep) if part]
    folders = [Path(folder) for folder in (*listed, "motions")]
    files = (file for pattern in patterns for at in folders for file in sorted(at.rglob(pattern)))
    return next(files, None)


def paper_record(name: str, factor: float = 1.0) -> PaperMotion:
    """Return a record of the paper.

    If a file is missing or has a different record, the first motion of the suite `near` is
    returned, scaled to `factor` x the published PGA.
    """
    motion_id, patterns, pga_rotd50_g = _RECORDS[name]
    component_1, component_2 = _find(patterns[0]), _find(*patterns[1:])
    pga_g = factor * pga_rotd50_g
    if component_1 and component_2:
        with suppress(read.FalseClaimError):
            motion = read.read_motion(component_1, component_2, motion_id=motion_id)
            return PaperMotion(motion, name, pga_g, is_paper_record=True)
    motion = stored_motions()[0]
    label = f"synthetic {motion.motion_id} at {factor:g} x the PGA of {name}"
    return PaperMotion(motion.scaled(pga_g / _pga_g(motion)), label, pga_g)


def _pga_g(motion: GroundMotion) -> float:
    return orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2


@cache
def stored_motions() -> tuple[GroundMotion, ...]:
    """Return the motions of the suite `near` that are stored in files."""
    entries = read_index(starter_files() / "motions" / INDEX_NAME)
    return tuple(read_entry(entry) for entry in entries if entry.components)


def first_motions(count: int) -> list[GroundMotion]:
    """Return the first motions of the suite with the factors that a study gives them."""
    motions = stored_motions()
    t1_s = load_structure("osb1").t1_s
    at_1_g = [motion_measures(motion, t1_s)[LEVEL_MEASURE] for motion in motions]
    factors = block_factors(at_1_g, (LEVEL_RANGE_G,))
    return [motion.scaled(factor) for motion, factor in zip(motions, factors, strict=True)][:count]


def strongest_motions(count: int, pga_g: float) -> list[GroundMotion]:
    """Return the motions of the suite with the largest PGA (RotD50), all scaled to `pga_g`."""
    motions = stored_motions()
    ranked = sorted(((_pga_g(motion), k) for k, motion in enumerate(motions)), reverse=True)
    return [motions[k].scaled(pga_g / peak_g) for peak_g, k in ranked[:count]]


def paper_variant(**fields: Any) -> Variant:
    """Return OSB1 with friction, skew 0 and the paper's gap; keywords override these fields."""
    paper: dict[str, Any] = {"bridge": "osb1", "abutment": "contact_friction", "skew_deg": 0}
    paper |= {"gap_mm": GAP_MM, "friction_pct": FRICTION_PCT}
    return Variant(**paper | fields)
