"""Figure 1 of the paper: the two-dimensional unit, and the rigid block that slides, tips or rocks.

Loops of one unit that is closed from the start (gap 0) and of one behind a gap, under constant and
varying normal force, are compared with radial return; blocks are compared with closed forms.
"""

from dataclasses import asdict
from math import pi
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from skewbridge.contact import ContactLaw
from skewbridge.verification.references.blocks import (
    TABLE_G_MPS2,
    UprightBlock,
    UprightHistory,
    run_block,
    run_upright,
    sliding_block,
)
from skewbridge.verification.references.closed_forms import (
    RockingBlock,
    rectangular_pulse_slip,
    sine_pulse_first_slip,
    straight_loop_work_j,
)
from skewbridge.verification.references.driven_unit import drive_unit, follow_law, path_work_j
from skewbridge.verification.references.live_model import Array, first_crossing_s
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

_KN: Final = 1.0e5
_KT: Final = 1.0e5
_FRICTION: Final = 0.3
_DEPTH_M: Final = 0.1
_STROKE_M: Final = 0.5
_ROWS: Final = 1200
_LIMIT_N: Final = _FRICTION * _KN * _DEPTH_M


def run(study: Study) -> None:
    """Run the study."""
    loops = {gap: _loops(gap, study) for gap in (0.0, 0.02)}
    _sliding_blocks(study)
    completed = sum(bool(np.isfinite(f).all()) for loop in loops.values() for _, f in loop.values())
    study.states("existing parts", "loops of one unit", completed)
    study.figures["unit"] = _unit_figure(loops)
    study.figures["rocking"] = _rocking_figure(_upright_blocks(study))


def _path(gap_m: float, variation: float) -> Array:
    """Return two cycles along the surface while the depth varies once per half cycle."""
    t = np.linspace(0.0, 2.0, _ROWS + 1)
    depth = _DEPTH_M * (1.0 + variation * np.sin(2.0 * pi * t))
    slip = _STROKE_M * np.sin(2.0 * pi * t)
    return np.column_stack([t, slip, np.zeros_like(t), -gap_m - depth])


def _approach(gap_m: float) -> Array:
    """Return a path that closes and opens the pair twice, without slip."""
    t = np.linspace(0.0, 2.0, _ROWS + 1)
    z = -0.5 * (_DEPTH_M + gap_m) * (1.0 - np.cos(2.0 * pi * t)) + 0.02 * np.sin(pi * t) ** 2
    return np.column_stack([t, np.zeros_like(t), np.zeros_like(t), z])


def _loops(gap_m: float, study: Study) -> dict[str, tuple[Array, Array]]:
    law = ContactLaw(kn_n_per_m=_KN, kt_n_per_m=_KT, friction=_FRICTION, gap_m=gap_m)
    result: dict[str, tuple[Array, Array]] = {}
    for name, path in (
        ("normal", _approach(gap_m)),
        ("constant", _path(gap_m, 0.0)),
        ("varying", _path(gap_m, 0.6)),
    ):
        forces = drive_unit(law, path).forces_n
        exact = follow_law(law, path, substeps=50)
        error = float(np.sqrt(np.mean(np.sum((forces - exact) ** 2, axis=1)))) / _LIMIT_N
        quantity = f"{name} loop, gap {1000 * gap_m:g} mm: RMS error over the limit"
        study.at_most(quantity, error, 0.01, "radial return on a fine grid")
        key = "unit behind a gap" if gap_m else "unit without gap"
        study.states(key, f"{name} loop", error)
        result[name] = (path, forces)
    path, forces = result["constant"]
    half = slice(len(path) // 2, None)
    work_j = path_work_j(path[half], forces[half])
    exact_j = straight_loop_work_j(_STROKE_M, _LIMIT_N / _KT, _LIMIT_N)
    study.relative(f"work per cycle, gap {1000 * gap_m:g} mm (J)", work_j, exact_j, 5e-3, "B7")
    return result


def _sliding_blocks(study: Study) -> None:
    def sine_mps2(t: Array) -> Array:
        return np.where(t <= 0.5, 0.5 * TABLE_G_MPS2 * np.sin(4.0 * pi * t), 0.0)

    def rectangle_mps2(t: Array) -> Array:
        return 0.25 * TABLE_G_MPS2 * (np.sign(0.2 + 1e-9 - t) + np.sign(0.2 - 1e-9 - t) + 2) / 2.0

    for mu in (0.1, 0.2, 0.3, 0.4):
        slid = run_block(sliding_block(mu), 2e-4, 0.6, base_mps2=sine_mps2)
        slip_m, exact = (
            slid.position_m[:, 0].min(),
            sine_pulse_first_slip(0.5 * TABLE_G_MPS2, 0.5, mu * TABLE_G_MPS2),
        )
        name = f"sliding block, sine pulse, friction {mu}: slip (m)"
        study.relative(name, slip_m, exact.slip_m, 5e-3, "B3")
    for mu in (0.1, 0.2, 0.3):
        slid = run_block(sliding_block(mu), 2e-4, 1.3, base_mps2=rectangle_mps2)
        exact_m = rectangular_pulse_slip(0.5 * TABLE_G_MPS2, 0.2, mu * TABLE_G_MPS2)
        name = f"sliding block, rectangular pulse, friction {mu}: slip (m)"
        study.relative(name, -slid.position_m[-1, 0], exact_m, 5e-3, "B3")


def _upright_blocks(study: Study) -> UprightHistory:
    histories: list[UprightHistory] = []
    for b, h in ((0.25, 1.0), (0.5, 1.5)):
        exact = RockingBlock(half_width_m=b, half_height_m=h, gravity_mps2=TABLE_G_MPS2)
        angle = 0.5 * exact.slenderness_rad
        released = run_upright(_upright(exact, friction=1.0, angle_rad=angle), 5e-4, 0.8)
        histories.append(released)
        name, quarter_s = f"block {b} x {h} m", exact.quarter_period_s(angle)
        found_s = first_crossing_s(released.t_s, released.angle_rad) or np.nan
        text = f"{name}: quarter period of rocking (s)"
        study.relative(text, found_s, quarter_s, 5e-3, "B9, Housner")
        _tip_or_slide(study, name, exact)
    return histories[0]


def _upright(exact: RockingBlock, **options: float) -> UprightBlock:
    return UprightBlock(**asdict(exact), mass_kg=1000.0, penalty_n_per_m=1e9, **options)


def _tip_or_slide(study: Study, name: str, exact: RockingBlock) -> None:
    """Push a block by an acceleration that grows after 1 s."""
    rate = 1.2
    for friction in (1.0, 0.2):
        block = _upright(exact, friction=friction)
        pushed = run_upright(block, 1e-3, 4.0, lambda t: rate * np.maximum(0.0, t - 1.0))
        lifted = (pushed.t_s > 1.0) & (pushed.openings_m.max(axis=1) > 0.0)
        if friction == 1.0:
            start = rate * (float(pushed.t_s[np.flatnonzero(lifted)[0]]) - 1.0)
            source = "B9, g b / h"
            study.relative(f"{name}: uplift at (m/s2)", start, exact.uplift_mps2, 0.02, source)
        else:
            slid = float(np.abs(np.diff(pushed.feet_m[:, 0])).max()) > 1e-3
            text = f"{name}, friction 0.2 < b / h: slides and does not lift"
            study.holds(text, truth=slid and not bool(lifted.any()), source="B9")


def _unit_figure(loops: dict[float, dict[str, tuple[Array, Array]]]) -> Figure:
    figure, axes = style.panels(1, 3, height_in=2.9)
    for (gap, data), colour, dashes in zip(
        loops.items(), (style.BLUE, style.ORANGE), ("-", "--"), strict=True
    ):
        path, forces = data["normal"]
        name = f"gap {1000 * gap:g} mm"
        style.line(
            axes[0, 0], 1000 * path[:, 3], forces[:, 2] / 1000, colour, name, lw=1.2, ls=dashes
        )
        for axis, key in ((axes[0, 1], "constant"), (axes[0, 2], "varying")):
            path, forces = data[key]
            style.line(axis, 1000 * path[:, 1], forces[:, 0] / 1000, colour, lw=1.2, ls=dashes)
    style.label(axes[0, 0], "normal displacement (mm)", "compression (kN)", "normal")
    style.label(axes[0, 1], "slip (mm)", "friction (kN)", "constant compression")
    style.label(axes[0, 2], "slip (mm)", "friction (kN)", "varying compression")
    style.legend(axes[0, 0])
    return figure


def _rocking_figure(history: UprightHistory) -> Figure:
    exact = RockingBlock(half_width_m=0.25, half_height_m=1.0, gravity_mps2=TABLE_G_MPS2)
    figure, axis = style.panel(height_in=2.6)
    style.line(axis, history.t_s, history.angle_rad / exact.slenderness_rad, style.BLUE, "OpenSees")
    quarter = exact.quarter_period_s(0.5 * exact.slenderness_rad)
    name = "upright after Housner's quarter"
    axis.axvline(quarter, color=style.ORANGE, ls="--", lw=1, label=name)
    axis.axhline(0.0, color=style.GREY, lw=0.6)
    style.dots(axis, [0.0], [0.5], style.BLACK)
    style.label(axis, "time (s)", "angle / slenderness (-)", "block 0.25 x 1 m released from rest")
    style.legend(axis)
    return figure
