"""The records of the paper's bridge studies: the user's own, a stand-in, or a synthetic pair.

Recorded motions can't be passed on with the package. They are looked for in the folders named by
the environment variable `SKEWBRIDGE_RECORDS` and in `motions/` of the working folder; whatever
replaces a missing one is called so on every figure.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.motions.index import IndexEntry, read_index
from skewbridge.motions.read import (
    SURROGATE_FACTOR,
    SURROGATE_FILES,
    SURROGATE_ID,
    WAHO_PGA_ROTD50_G,
    FalseClaimError,
    read_motion,
)
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.motions.suite import read_entry
from skewbridge.motions.trace import Given
from skewbridge.provenance.digests import PACKAGE
from skewbridge.units import G_MPS2

FOLDERS_VARIABLE: Final = "SKEWBRIDGE_RECORDS"
# source: PEER NGA-West2 flatfile, RSN 1087 (Northridge 1994, Tarzana), RotD50 PGA
TARZANA_PGA_ROTD50_G: Final = 1.6440
# The package's motions have no pulse: at the peak of WAHO they leave the gaps of OSB1 open, and
# what the paper says of contact could not be looked at.
CLOSING_FACTOR: Final = 3.0

# source: PEER NGA-West2, RSN 6 (Imperial Valley 1940, El Centro): geometric mean of the two
# components, 0.2808 and 0.2107 g
EL_CENTRO_PGA_G: Final = 0.2432


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperMotion:
    """A motion of a study, longitudinal component first.

    Attributes:
        motion: The motion at the factor of the study.
        label: Name for figures; says so when it is not the paper's record.
    """

    motion: GroundMotion
    label: str
    is_paper_record: bool

    @property
    def stand_in(self) -> str:
        """What to add to the name of a case that is not under the paper's record."""
        return "" if self.is_paper_record else f" ({self.label})"


def tarzana() -> PaperMotion:
    """Return Tarzana with 090 longitudinal and 000 transverse, or a synthetic pair as strong."""
    files = _find("*TAR090*"), _find("*TAR360*") or _find("*TAR000*")
    return _record(files, "TAR", "Tarzana (TAR)") or _synthetic(TARZANA_PGA_ROTD50_G, "Tarzana")


def waho() -> PaperMotion:
    """Return WAHO with 090 longitudinal and 000 transverse, its surrogate, or a synthetic pair."""
    files = _find("*WAH090*"), _find("*WAH000*")
    if found := _record(files, "RSN811_WAHO", "WAHO"):
        return found
    north, east = (_find(name) for name in SURROGATE_FILES)
    if north and east:
        motion = read_motion(east, north, Given(unit="g"), motion_id=SURROGATE_ID)
        label = f"surrogate for WAHO: Capitola x {SURROGATE_FACTOR:g}"
        scaled = motion.scaled(SURROGATE_FACTOR)
        return PaperMotion(motion=scaled, label=label, is_paper_record=False)
    return _synthetic(WAHO_PGA_ROTD50_G, "WAHO", CLOSING_FACTOR)


def el_centro() -> PaperMotion:
    """Return El Centro with 180 longitudinal and 270 transverse, or a synthetic pair as strong."""
    files = _find("*ELC180*"), _find("*ELC270*")
    found = _record(files, "RSN6_ELC", "El Centro (ELC)")
    return found or _synthetic(EL_CENTRO_PGA_G, "El Centro")


def _find(pattern: str) -> Path | None:
    """Return the first file of that name in the folders, in order of names."""
    named = [part for part in os.environ.get(FOLDERS_VARIABLE, "").split(os.pathsep) if part]
    found = (file for folder in (*named, "motions") for file in sorted(Path(folder).rglob(pattern)))
    return next(found, None)


def _record(
    files: tuple[Path | None, Path | None], motion_id: str, label: str
) -> PaperMotion | None:
    """Return the paper's record from its two files; None without them or if they are not it."""
    first, second = files
    if first is None or second is None:
        return None
    try:
        motion = read_motion(first, second, motion_id=motion_id)
    except FalseClaimError:
        return None
    return PaperMotion(motion=motion, label=label, is_paper_record=True)


def embedded_entries() -> list[IndexEntry]:
    """Return what the index says of the stored motions of the package's suite.

    Raises:
        InputError: The suite is not in the working folder.
    """
    places = [folder / "motions" / "index.csv" for folder in (Path(), PACKAGE.parents[1])]
    if (index := next(filter(Path.is_file, places), None)) is None:
        raise InputError(
            "the package's own suite motions/index.csv is not in the working folder; for the "
            f"studies under one record, {FOLDERS_VARIABLE} or motions/ may hold it"
        )
    return [entry for entry in read_index(index) if entry.components]


def embedded_motions() -> list[GroundMotion]:
    """Return the stored motions of the package's suite, unscaled.

    Raises:
        InputError: The suite is not in the working folder.
    """
    return [read_entry(entry) for entry in embedded_entries()]


def _synthetic(pga_rotd50_g: float, wanted: str, factor: float = 1.0) -> PaperMotion:
    """Return the first motion of the package's suite, brought to a multiple of a published peak."""
    motion = embedded_motions()[0]
    pga_g = orbit_rotd50(motion.accel_1_mps2, motion.accel_2_mps2) / G_MPS2
    return PaperMotion(
        motion=motion.scaled(factor * pga_rotd50_g / pga_g),
        label=f"synthetic {motion.motion_id} at {factor:g} x the peak of {wanted}",
        is_paper_record=False,
    )
