"""Figures 7 and 8 of the paper: the skew deck of the shake-table tests of Wu et al. (2019).

Mass, bearings, damping and the table motion of the tests are not public, and the rotation varies
four- to fivefold over the plausible range. So there is no comparison with the tests. The deck is
compared with the same equations solved without OpenSees, and only statements that do not need the
tests are judged.
"""

from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.units import MM
from skewbridge.verification.references.cases import C1, DeckCase, bearing_fields, deck_case
from skewbridge.verification.references.deck_model import (
    CORNERS,
    BaseAcceleration,
    DeckHistory,
    make_deck,
)
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import PaperMotion, el_centro

GAPS_MM: Final = (3.18, 6.35)  # source: the paper, runs 123 and 213
FRICTION: Final = 0.4  # source: the paper
KN_N_PER_M: Final = 2.0e7  # source: the paper
DURATION_S: Final = 20.0
_DT_S: Final = 2.5e-4
_PREDICTABLE_S: Final = 2.5
_SHOWN_S: Final = 8.0
_NAMES: Final = {"ra": "right acute", "ro": "right obtuse", "lo": "left obtuse", "la": "left acute"}


def wu_case(gap_mm: float, **changes: Any) -> DeckCase:
    """Return the deck of the tests with a gap, read as perpendicular to the end."""
    # ASSUME mass, period and damping of the bearings (not public); no scaling of time.
    fields: dict[str, Any] = {
        "mass_kg": 5000.0,
        "damping_ratio": 0.07,
        "gap_normal_m": gap_mm * MM,
        "friction": FRICTION,
        "normal_stiffness_n_per_m": KN_N_PER_M,
        "dt_s": _DT_S,
        "duration_s": DURATION_S,
        "motion": ("recorded", "recorded"),
    }
    # source: plan from the paper
    plan = bearing_fields(length_m=5.03, width_m=1.07, skew_deg=60.0, period_s=0.45)
    return DeckCase.model_validate(plan | fields | changes)


def run(study: Study) -> None:
    """Run the study."""
    motion = el_centro()
    ground = BaseAcceleration.of_motion(motion.motion)
    rows: list[dict[str, float | str]] = []
    for gap in GAPS_MM:
        history = run_deck(wu_case(gap), ground)
        ode = run_deck(wu_case(gap, solver="penalty"), ground)
        _compare(study, gap, history, ode)
        _statements(study, gap, history)
        rows += [
            {"gap_mm": gap, "solver": name, "motion": motion.label} | _demands(found)
            for name, found in (("opensees", history), ("penalty", ode))
        ]
        if gap == GAPS_MM[0]:
            study.figures["deformations"] = _deformations(history, motion)
            study.figures["forces"] = _forces(history, motion)
    # Half a period of a mass on its penalty; the same share of the mass acts at a corner.
    times_s = [
        (case.mass_kg / case.normal_stiffness_n_per_m) ** 0.5
        for case in (wu_case(GAPS_MM[0]), deck_case(C1))
    ]
    study.states("longer contact", "closed form", times_s[0] / times_s[1], 1.0)
    study.tables["peaks"] = pd.DataFrame(rows)


def _compare(study: Study, gap: float, history: DeckHistory, ode: DeckHistory) -> None:
    name, source = f"gap {gap:g} mm", "own Runge-Kutta integration of the penalty equation"
    if gap == GAPS_MM[1]:
        peaks, exact = history.peaks(), ode.peaks()
        for key in ("ux_m", "uy_m", "theta_rad"):
            text = f"{name}: peak {key} over {DURATION_S:g} s"
            study.relative(text, peaks[key], exact[key], 0.02, source)
        return
    # With the small gap the motion is chaotic after some seconds: only the start is compared.
    early = history.t_s <= _PREDICTABLE_S
    error = float(np.abs((history.q - ode.q)[early, :2]).max())
    text = f"{name}: difference in the first {_PREDICTABLE_S:g} s (m)"
    study.at_most(text, error, 0.05 * MM, source)


def _statements(study: Study, gap: float, history: DeckHistory) -> None:
    name = f"gap {gap:g} mm"
    demands = _demands(history)
    study.states("skew deck rotates", name, demands["theta_mrad"])
    for side in ("r", "l"):
        openings_mm = (demands[f"away_{side}{kind}_mm"] for kind in "ao")
        study.states("acute corner moves away", f"{name}, {_NAMES[side + 'a']}", *openings_mm)
    excess = np.abs(history.tangentials_n) - FRICTION * history.normals_n
    study.at_most(
        f"{name}: friction beyond friction x compression, over its largest",
        max(0.0, float(excess.max())) / (FRICTION * float(history.normals_n.max())),
        0.1,
        "cone; one step of the predicted compression",
    )


def _demands(history: DeckHistory) -> dict[str, float]:
    """Return peaks in mm, mrad and kN; `away` is the largest opening beyond the gap."""
    peaks = history.peaks()
    result = {
        "ux_mm": peaks["ux_m"] / MM,
        "uy_mm": peaks["uy_m"] / MM,
        "theta_mrad": 1e3 * peaks["theta_rad"],
    }
    gap = float(history.openings_m[0, 0])
    for k, corner in enumerate(CORNERS):
        result[f"away_{corner}_mm"] = (float(history.openings_m[:, k].max()) - gap) / MM
        result[f"normal_{corner}_kn"] = float(history.normals_n[:, k].max()) / 1e3
    return result


def _deformations(history: DeckHistory, motion: PaperMotion) -> Figure:
    title = f"{motion.label}, gap {GAPS_MM[0]:g} mm"
    names = [f"{_NAMES[corner]} (mm)" for corner in CORNERS]
    figure, axes = style.time_panels(*names, height_in=6.4, title=title)
    shown = history.t_s <= _SHOWN_S
    slips = history.q @ make_deck(wu_case(GAPS_MM[0])).tangent_rows.T
    t = history.t_s[shown]
    for k, axis in enumerate(axes):
        style.line(axis, t, slips[shown, k] / MM, style.ORANGE, "tangential")
        style.line(axis, t, history.openings_m[shown, k] / MM, style.BLUE, "opening")
        axis.axhline(0.0, color=style.GREY, lw=0.8, ls="--")
    style.legend_above(figure, axes[0])
    return figure


def _forces(history: DeckHistory, motion: PaperMotion) -> Figure:
    title = f"{motion.label}, gap {GAPS_MM[0]:g} mm"
    figure, axes = style.time_panels(
        "compression (kN)", "friction (kN)", height_in=4.4, title=title
    )
    shown = history.t_s <= _SHOWN_S
    colours = (style.BLUE, style.ORANGE, style.GREEN, style.PINK)
    for k, (corner, colour) in enumerate(zip(CORNERS, colours, strict=True)):
        for axis, values in zip(axes, (history.normals_n, history.tangentials_n), strict=True):
            style.line(axis, history.t_s[shown], values[shown, k] / 1e3, colour, _NAMES[corner])
    style.legend_above(figure, axes[0])
    return figure
