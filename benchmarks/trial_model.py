"""A two-column bridge as in an ordinary script: no contact units, nothing of our model.

Two force-based fiber columns of 5 points and 188 fibers, 10 elastic deck elements, 4 gap springs;
about OSB1 in size. The step loops of several programs are compared on it.
"""

from dataclasses import dataclass

import openseespy.opensees as ops

from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2

LENGTH_M, WIDTH_M, HEIGHT_M, SPACING_M = 60.0, 12.0, 7.0, 6.0
DECK_ELEMENTS = 10
WEIGHT_N = 19.0e6
DAMPING = (0.487, 0.0, 0.0, 0.00406)
_GAP_M = 0.05
_CENTRE = DECK_ELEMENTS // 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One history of the model.

    Attributes:
        gap_n_per_m: Stiffness of each gap spring once closed.
    """

    motion: GroundMotion
    gap_n_per_m: float = 5.0e7

    def build(self) -> None:
        """Build the model in a fresh domain, at rest under its weight, with its motion."""
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        _deck()
        _columns()
        _gaps(self.gap_n_per_m)
        _gravity()
        ops.rayleigh(*DAMPING)
        for direction, values in enumerate(self.motion.components, start=1):
            ops.timeSeries(
                "Path", 10 + direction, "-dt", self.motion.dt_s, "-values", *values.tolist()
            )
            ops.pattern("UniformExcitation", 10 + direction, direction, "-accel", 10 + direction)


def end_m() -> tuple[float, float]:
    """Return where the middle of the deck is, along x and y."""
    return ops.nodeDisp(_CENTRE, 1), ops.nodeDisp(_CENTRE, 2)


def _deck() -> None:
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    mass_kg = WEIGHT_N / G_MPS2 / DECK_ELEMENTS
    for k in range(DECK_ELEMENTS + 1):
        ops.node(k, LENGTH_M * (k / DECK_ELEMENTS - 0.5), 0.0, HEIGHT_M)
        share = 0.5 if k in (0, DECK_ELEMENTS) else 1.0
        turning = share * mass_kg * WIDTH_M**2 / 12.0
        ops.mass(k, *[share * mass_kg] * 3, turning, 1.0, turning)
    for k in range(DECK_ELEMENTS):
        section = (6.0, 2.8e10, 1.17e10, 10.0, 3.8, 114.0)
        ops.element("elasticBeamColumn", 1 + k, k, k + 1, *section, 1)


def _columns() -> None:
    """Two columns from fixed bases to the deck's middle."""
    ops.uniaxialMaterial("Concrete01", 1, -4.7e7, -0.0035, -4.0e7, -0.015)
    ops.uniaxialMaterial("Concrete01", 2, -3.5e7, -0.002, 0.0, -0.005)
    ops.uniaxialMaterial("Steel02", 3, 4.7e8, 2.0e11, 0.01, 18.5, 0.925, 0.15)
    ops.section("Fiber", 1, "-GJ", 1.0e9)
    ops.patch("circ", 1, 16, 7, 0.0, 0.0, 0.0, 0.76, 0.0, 360.0)
    ops.patch("circ", 2, 16, 2, 0.0, 0.0, 0.76, 0.84, 0.0, 360.0)
    ops.layer("circ", 3, 44, 1.006e-3, 0.0, 0.0, 0.72)
    ops.beamIntegration("Lobatto", 1, 1, 5)
    ops.geomTransf("PDelta", 2, 1.0, 0.0, 0.0)
    for number, side in enumerate((-1, 1)):
        base, top = 20 + number, 30 + number
        for node, height_m in ((base, 0.0), (top, HEIGHT_M)):
            ops.node(node, 0.0, side * SPACING_M / 2, height_m)
        ops.fix(base, 1, 1, 1, 1, 1, 1)
        ops.rigidLink("beam", _CENTRE, top)
        ops.element("forceBeamColumn", 20 + number, base, top, 2, 1)


def _gaps(stiffness_n_per_m: float) -> None:
    """Rollers with pads at both ends, and two gap springs along the bridge at each."""
    ops.uniaxialMaterial("ElasticPPGap", 10, stiffness_n_per_m, -4.0e6, -_GAP_M)
    ops.uniaxialMaterial("Elastic", 11, 1.0e10)
    ops.uniaxialMaterial("ElasticPP", 12, 8.0e6, 0.05)
    for number, (deck, outward) in enumerate(((0, -1.0), (DECK_ELEMENTS, 1.0))):
        for side in (-1, 1):
            corner, ground = 40 + 10 * number + side, 60 + 10 * number + side
            place = (ops.nodeCoord(deck, 1), side * WIDTH_M / 2, HEIGHT_M)
            for node in (corner, ground):
                ops.node(node, *place)
            ops.fix(ground, 1, 1, 1, 1, 1, 1)
            ops.rigidLink("beam", deck, corner)
            springs = ("-mat", 10, 12, 11, 12, "-dir", 1, 1, 3, 2)
            # the first axis points inwards: the spring shortens when the deck moves outwards
            inward = ("-orient", -outward, 0.0, 0.0, 0.0, 1.0, 0.0)
            ops.element("zeroLength", ground, ground, corner, *springs, *inward)


def _gravity() -> None:
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for k in range(DECK_ELEMENTS + 1):
        share = 0.5 if k in (0, DECK_ELEMENTS) else 1.0
        ops.load(k, 0.0, 0.0, -share * WEIGHT_N / DECK_ELEMENTS, 0.0, 0.0, 0.0)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", 1.0e-10, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 0.2)
    ops.analysis("Static")
    if ops.analyze(5) != 0:
        message = "the trial model does not carry its weight"
        raise RuntimeError(message)
    ops.loadConst("-time", 0.0)
