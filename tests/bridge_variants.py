"""Variants of bridges and their analyses."""

import openseespy.opensees as ops

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion


def seated_bridges() -> list[str]:
    return [name for name in bridge_names() if load_bridge(name).abutment is not None]


def variant(
    skew_deg: int = 30,
    abutment: str = "contact_friction",
    bridge: str = "osb1",
    gap_mm: int = 51,
    friction_pct: int = 50,
) -> Variant:
    place = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction_pct": friction_pct}
    return Variant(bridge=bridge, abutment=abutment, **place)


def analysed(
    case, motion=None, options=None, *, scale=1.0, incidence_deg=0.0, supports=None, log_path=None,
    **settings,
):  # fmt: skip
    given = {"scale": scale, "incidence_deg": incidence_deg, "supports": supports or {}}
    return analyse(
        case, Excitation(motion=motion or strong_motion(), **given), AnalysisSettings(**settings),
        options or ModelOptions(), histories=True, log_path=log_path,
    )  # fmt: skip


def static_steps(count, system, tolerance):
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system(system)
    ops.test("NormDispIncr", tolerance, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / count)
    ops.analysis("Static", "-noWarnings")
    assert ops.analyze(count) == 0
