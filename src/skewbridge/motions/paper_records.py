"""The WAHO record of the paper: accepted only if it is the published one.

Its waveforms can't be passed on. A file that claims to be it must have its published peak; without
one, a surrogate of the same earthquake is used, and called a surrogate.
"""

import re
from typing import Final

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.spectrum import orbit_rotd50
from skewbridge.units import G_MPS2

# source: PEER NGA-West2 flatfile, RSN 811 (Loma Prieta 1989, WAHO), RotD50 PGA
WAHO_PGA_ROTD50_G: Final = 0.53730
WAHO_TOLERANCE: Final = 0.02

# source: Loma Prieta 1989, Capitola (FEMA P-695 far-field 12101 = NGA RSN 752); of 47 public pairs
# the one nearest to the published WAHO RotD50 spectrum (sd of ln ratio 0.41, a loose match).
SURROGATE_FILES: Final = ("121011.txt", "121012.txt")
SURROGATE_FACTOR: Final = 0.93
SURROGATE_ID: Final = "surrogate_for_WAHO_capitola_x0.93"

_CLAIM = re.compile(r"RSN0*811(?!\d)|(?<![A-Z])WAHO?(?![A-Z])", re.IGNORECASE)


class FalseClaimError(InputError):
    """A motion calls itself the WAHO record and is not: use the surrogate instead."""


def claims_to_be_waho(*names: str) -> bool:
    """Say whether any of some names (motion, station, files) is that of the WAHO record."""
    return SURROGATE_ID not in names and any(_CLAIM.search(name) for name in names)


def refuse_false_waho(motion: GroundMotion) -> None:
    """Refuse a motion that claims to be WAHO but has not its published peak.

    Raises:
        FalseClaimError: RotD50 PGA more than 2 % off.
    """
    if not claims_to_be_waho(motion.motion_id, motion.station, *motion.files):
        return
    pga_g = orbit_rotd50(*motion.components) / G_MPS2
    if abs(pga_g / WAHO_PGA_ROTD50_G - 1.0) > WAHO_TOLERANCE:
        raise FalseClaimError(
            f"motion {motion.motion_id} claims to be the WAHO record, but its RotD50 PGA is "
            f"{pga_g:.4f} g; the published one is {WAHO_PGA_ROTD50_G:.4f} g, "
            f"{WAHO_TOLERANCE:.0%} allowed. Rename it, or use the surrogate.",
            motion_id=motion.motion_id,
        )
