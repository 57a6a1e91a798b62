"""Friction at the abutments of OSB1: figures 10 to 12, friction by place, and the abutment models.

`run_abutment` repeats figure 10, the abutment sub-structure under Tarzana with and without
friction. The paper mentions skew 0 and skew 25 degrees and does not name the kind of keys, so the
study runs both skews, with sacrificial keys (those of the default model) and with monolithic keys.
`run` repeats figures 11 and 12 without skew, under the default scheme and the paper's.
`run_places` has friction at walls, at keys or at both, without and with skew. `run_models` compares
all abutment models with skew and without, and OSB2S with friction and without; the paper's section
6 announces these comparisons. A stand-in for a record of the paper is named on the figures and in
the cases of the statements.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from functools import partial
from itertools import product
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisScheme, AnalysisSettings
from skewbridge.analysis.transient import AnalysisResult
from skewbridge.bridge.geometry import contact_column
from skewbridge.statuses import RAN
from skewbridge.units import KJ, KN, MM
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import FrictionAt, ModelOptions
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.statements import relative_change
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.paper_runs import (
    DURATION_S,
    FRICTION_PCT,
    LEAST_WALL_FORCE,
    HalfCycle,
    PaperMotion,
    analysis,
    half_cycles,
    histories_of,
    paper_variant,
    rms_change,
    stick_slip_changes,
    tarzana,
    waho,
    wall_strength_kn,
)

type Curve = tuple[Array, Array]

_WITHOUT: Final = "without friction, this model"


def _draw_pair(axis: Axes, curves: Sequence[Curve]) -> None:
    """Draw the curves with and without friction, the one with friction on top."""
    with_friction, without = curves
    style.line(axis, *without, style.ORANGE, "no friction", lw=0.8)
    style.line(axis, *with_friction, style.BLUE, "friction 0.5")


def _judge_cycles(
    states: Callable[..., None], statement: str, case: str, cycles: list[HalfCycle]
) -> None:
    """Judge whether friction lowers the peaks of the half cycles in contact."""
    lower = [cycle.change < 0.0 for cycle in cycles if cycle.has_contact]
    states(statement, case, sum(lower), len(lower))


type Keys = Literal["sacrificial", "monolithic"]
type AbutmentPair = tuple[AbutmentHistory, AbutmentHistory]
"""With friction, without."""

_ABUTMENT_SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
_KEYS: Final[tuple[Keys, ...]] = ("sacrificial", "monolithic")  # the default model's first
PLACES: Final[tuple[FrictionAt, ...]] = ("all", "walls", "keys")
_FAST_HZ: Final = 5.0
_PUSH_M: Final = 0.09


def run_abutment(study: Study) -> None:
    """Run the study of figure 10."""
    record = tarzana()
    places: list[dict[str, Any]] = []
    for motion, keys, skew in product(record.runs(), _KEYS, _ABUTMENT_SKEWS_DEG):
        options = ModelOptions(keys=keys)
        pair = _history(motion, options, skew), _history(motion, options, skew, friction_pct=0)
        case = f"skew {skew}, {keys} keys{record.stand_in}"
        wall_kn = min(float(h.force_n[:, 0].max()) / KN for h in pair)
        met = wall_kn > LEAST_WALL_FORCE * wall_strength_kn(skew)
        states = partial(study.states, run=motion.run, premise=met)
        _judge_abutment(states, case, pair)
        if keys == _KEYS[0]:
            runs = {"all": pair[0]} | {
                place: _history(motion, ModelOptions(friction_at=place), skew)
                for place in PLACES[1:]
            }
            without = pair[1].disp_m
            changes = (rms_change(runs[place].disp_m, without) for place in PLACES[1:])
            states("backwall makes it", case, *(float(change[1]) for change in changes))
            names = {"run": motion.run.name, "skew_deg": skew}
            places += [
                {**names, "friction_at": place, **_place_row(history, pair[1])}
                for place, history in runs.items()
            ]
        if motion.is_nominal:
            _report_abutment(study, case, pair)
            label = f"skew{skew:02d}_{keys}"
            study.figures[label] = _abutment_figure(pair, motion)
            study.tables[f"{label}_ledger"] = _ledger(pair[0])
    study.tables["places"] = pd.DataFrame(places)
    _judge_static_push(study)


def _place_row(history: AbutmentHistory, without: AbutmentHistory) -> dict[str, float]:
    """Return the relative changes of the peaks by friction, and its work at walls and keys."""
    peaks, plain = _peaks(history), _peaks(without)
    work_kj = {
        f"work at {kind}s (kJ)": sum(
            unit.slip_work_j for unit in history.ledger if kind in unit.name
        )
        / KJ
        for kind in ("backwall", "key")
    }
    return {name: relative_change(peaks[name], plain[name]) for name in peaks} | work_kj


def _history(
    motion: PaperMotion, options: ModelOptions, skew_deg: int, friction_pct: int = FRICTION_PCT
) -> AbutmentHistory:
    variant = paper_variant(skew_deg=skew_deg, friction_pct=friction_pct)
    settings = AnalysisSettings(duration_s=DURATION_S)
    return abutment_history(variant, Excitation(motion=motion.motion), settings, options)


def _report_abutment(study: Study, case: str, pair: AbutmentPair) -> None:
    """Report the peaks with friction against those without; check that both histories finish."""
    with_friction, without = (_peaks(history) for history in pair)
    for quantity, value in with_friction.items():
        text = f"{case}: peak {quantity}, friction 0.5 against 0"
        study.report(text, value, without[quantity], _WITHOUT)
    slip_kj = sum(unit.slip_work_j for unit in pair[0].ledger) / KJ
    study.report(f"{case}: work of friction (kJ)", slip_kj, 0.0, _WITHOUT)
    is_whole = all(history.is_complete for history in pair)
    text = f"{case}: both histories reach their end"
    study.holds(text, truth=is_whole, source="this model")


def _peaks(history: AbutmentHistory) -> dict[str, float]:
    x_m, y_m = history.disp_m.T
    x_n, y_n = history.force_n.T
    return {
        "into the backfill (m)": float(x_m.max()),
        "away from the backfill (m)": float(-x_m.min()),
        "transverse (m)": float(np.abs(y_m).max()),
        "force into the backfill (kN)": float(x_n.max()) / KN,
        "transverse force (kN)": float(np.abs(y_n).max()) / KN,
    }


def _judge_abutment(states: Callable[..., None], case: str, pair: AbutmentPair) -> None:
    """Judge the statements on the loops of one case with friction against those without."""

    def both(value: Callable[[AbutmentHistory], float]) -> list[float]:
        return [float(value(history)) for history in pair]

    for name, peaks in (
        ("into the fill", both(lambda h: h.disp_m[:, 0].max())),
        ("away from the fill", both(lambda h: (-h.disp_m[:, 0]).max())),
        ("force into the fill", both(lambda h: h.force_n[:, 0].max())),
    ):
        states("longitudinal hardly changes", f"{case}, {name}", *peaks)
    with_friction, without = pair
    keys = _units(with_friction, "key")
    forces = with_friction.normals_n[:, keys], with_friction.friction_n[:, keys]
    states("keys stick and slip", case, stick_slip_changes(*forces, FRICTION_PCT / 100))
    fast = both(lambda h: _fast_rms(h.t_s, h.force_n[:, 0]) / KN)
    states("fast vibration", case, *fast)
    along, across = rms_change(with_friction.disp_m, without.disp_m).tolist()
    states("transverse differs more", f"{case}, RMS of the displacement", across, along)
    rough, smooth = (
        [np.trapezoid(h.force_n[:, axis], h.disp_m[:, axis]) for axis in (0, 1)] for h in pair
    )
    along, across = (
        float(abs(one / other - 1.0)) for one, other in zip(rough, smooth, strict=True)
    )
    states("transverse differs more", f"{case}, work of the loops", across, along)
    closures = sum(unit.closures for unit in with_friction.ledger if "backwall" in unit.name)
    states("several contacts", case, closures)
    states("transverse peak", case, *both(lambda h: np.abs(h.disp_m[:, 1]).max()))
    walls = [(h.normals_n[:, _units(h, "backwall")] > 0.0).any(axis=1) for h in pair]
    cycles = half_cycles(without.t_s, without.disp_m, with_friction.disp_m, 1, walls)
    _judge_cycles(states, "transverse cycles", case, cycles)


def _units(history: AbutmentHistory, kind: str) -> list[int]:
    return [index for index, name in enumerate(history.unit_names) if kind in name]


def _fast_rms(t_s: Array, force_n: Array) -> float:
    """Return the RMS of the frequencies above `_FAST_HZ`, on a regular grid of the same length."""
    grid_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    spectrum = np.fft.rfft(np.interp(grid_s, t_s, force_n))
    spectrum[np.fft.rfftfreq(len(grid_s), grid_s[1] - grid_s[0]) < _FAST_HZ] = 0.0
    return float(np.sqrt(np.mean(np.fft.irfft(spectrum, len(grid_s)) ** 2)))


def _judge_static_push(study: Study) -> None:
    """Judge whether a push along one axis without skew is independent of friction."""
    for axis, angle_deg in (("longitudinal", 0.0), ("transverse", 90.0)):
        rough, smooth = (
            push_abutment(
                paper_variant(friction_pct=friction_pct),
                ModelOptions(),
                angle_deg=angle_deg,
                max_disp_m=_PUSH_M,
            ).force_n
            for friction_pct in (FRICTION_PCT, 0)
        )
        change = float(np.abs(rough - smooth).max() / np.abs(smooth).max())
        study.states("static push", f"skew 0, {axis}", change)


def _abutment_figure(pair: AbutmentPair, motion: PaperMotion) -> Figure:
    figure, axes = style.panels(1, 2, height_in=3.0)
    for column, title in enumerate(("longitudinal (u)", "transverse (w)")):
        curves = [(h.disp_m[:, column] / MM, h.force_n[:, column] / (1000 * KN)) for h in pair]
        _draw_pair(axes[0, column], curves)
        style.label(axes[0, column], "displacement (mm)", "force on the deck (MN)", title)
    style.legend(axes[0, 0], loc="best")
    figure.suptitle(motion.label, fontsize=9)
    return figure


def _ledger(history: AbutmentHistory) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {
                "contact": unit.name,
                "closures": unit.closures,
                "contact_time_s": unit.contact_time_s,
                "max_normal_kn": unit.max_normal_n / KN,
                "max_friction_kn": unit.max_friction_n / KN,
                "slip_work_kj": unit.slip_work_j / KJ,
            }
            for unit in history.ledger
        ]
    )


type Pair = tuple[AnalysisResult, AnalysisResult]
"""With friction, without."""

SCHEMES: Final[tuple[AnalysisScheme, ...]] = ("default", "paper")
SKEWS_DEG: Final = (0, 30)
_DEMANDS: Final = (
    "deck_disp_x_m",
    "deck_disp_y_m",
    "deck_disp_m",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)
_DISPLACEMENTS: Final = {
    "resultant": "deck_disp_m",
    "longitudinal": "deck_disp_x_m",
    "transverse": "deck_disp_y_m",
}
_AXES: Final = {"longitudinal": "x", "transverse": "y"}
_SIDES: Final = ("left", "right")

_PLACE_DEMANDS: Final = {
    "column_shear_kn": "column shear",
    "column_drift_ratio": "drift",
    "deck_disp_m": "displacement",
    "deck_disp_y_m": "transverse displ.",
    "deck_rotation_rad": "rotation",
    "unseating_m": "unseating",
    "abutment_passive_m": "passive",
}
# Units without friction, by the place of friction.
_FREE: Final = {"walls": "key", "keys": "backwall"}
# A deck that does not turn has no rotation to compare with.
_LEAST: Final = {"deck_rotation_rad": 1e-4}

# The five models of the paper.
_MODEL_COLOURS: Final = {
    "roller": style.GREY,
    "simplified": style.PINK,
    "spring": style.GREEN,
    "contact": style.ORANGE,
    "contact_friction": style.BLUE,
}
_MODEL_DEMANDS: Final = (
    "deck_disp_m",
    "deck_rotation_rad",
    "column_shear_kn",
    "column_drift_ratio",
    "unseating_m",
    "acute_corner_unseating_m",
    "bearing_disp_m",
    "backwall_force_kn",
    "shear_key_force_kn",
)


def run(study: Study) -> None:
    """Run the study of figures 11 and 12."""
    record = waho()
    rough, smooth = paper_variant(), paper_variant(friction_pct=0)
    for scheme, motion in product(SCHEMES, record.runs()):
        if scheme == "paper" and motion.run.scale is None:
            continue  # nine seconds an analysis: this scheme runs the record at its scales only
        pair = analysis(rough, motion, scheme), analysis(smooth, motion, scheme)
        states = partial(study.states, run=motion.run, premise=_has_wall_force(pair, 0))
        case = f"{scheme} scheme{record.stand_in}"
        _judge(states, case, pair, same_record=motion.is_paper_record)
        if motion.is_nominal:
            _compare(study, f"{scheme} scheme", pair)
        if motion.is_nominal and scheme == SCHEMES[0]:
            cycles = _cycles(pair, "y")
            study.figures["displacements"] = _displacement_figure(pair, motion)
            study.figures["hysteresis"] = _hysteresis_figure(pair, motion)
            study.figures["cycles"] = _cycle_figure(cycles, motion)
            study.tables["cycles"] = pd.DataFrame(
                [asdict(cycle) | {"change": cycle.change} for cycle in cycles]
            )


def _compare(study: Study, case: str, pair: Pair) -> None:
    """Report the demands with friction against those without; check that the runs are valid."""
    with_friction, without = (result.whole_history for result in pair)
    for demand in _DEMANDS:
        text = f"{case}: {demand}, friction 0.5 against 0"
        study.report(text, with_friction[demand], without[demand], _WITHOUT)
    study.report(f"{case}: slip_work_kj", with_friction["slip_work_kj"], 0.0, _WITHOUT)
    is_whole = all(result.status == "ok" for result in pair)
    text = f"{case}: both analyses end with status ok"
    study.holds(text, truth=is_whole, source="this model")
    least_kn = min(with_friction["backwall_force_kn"], without["backwall_force_kn"])
    study.holds(f"{case}: the backwalls close", truth=least_kn > 0.0, source="this motion")


def _has_wall_force(runs: Iterable[AnalysisResult], skew_deg: int) -> bool:
    """Return whether the deck pushes a wall in every run with a share of its strength."""
    least_kn = min(result.whole_history["backwall_force_kn"] for result in runs)
    return least_kn > LEAST_WALL_FORCE * wall_strength_kn(skew_deg)


def _judge(states: Callable[..., None], case: str, pair: Pair, *, same_record: bool) -> None:
    """Judge the statements on the straight bridge with friction against the one without."""
    cycles = {axis: _cycles(pair, column) for axis, column in _AXES.items()}
    for axis, found in cycles.items():
        _judge_cycles(states, "bridge cycles", f"{case}, {axis}", found)
    for axis, column in _AXES.items():
        change = _history_change(pair, f"deck_u{column}_m")
        states("axes are coupled", f"{case}, {axis}", change)
    with_friction, without = (result.whole_history for result in pair)
    for name, demand in _DISPLACEMENTS.items():
        peaks = with_friction[demand], without[demand]
        states("displacement is reduced", f"{case}, {name}", *peaks)
        claim = "displacement by 2 to 3 percent"
        states(claim, f"{case}, {name}", *peaks, same_record=same_record)
    shears = with_friction["column_shear_kn"], without["column_shear_kn"]
    states("shear is reduced", case, *shears)
    shear, displacement = (
        1.0 - with_friction[demand] / without[demand]
        for demand in ("column_shear_kn", "deck_disp_m")
    )
    states("shear by as much", case, abs(shear - displacement))
    for side in _SIDES:
        along, across = (_history_change(pair, f"abutment_{side}_{axis}_kn") for axis in ("x", "y"))
        states("bridge transverse loops", f"{case}, {side} abutment", across, along)
    states("keys stick and slip", case, _key_changes(pair[0]))
    for axis, found in cycles.items():
        changes = [abs(cycle.peak_with_m - cycle.peak_without_m) for cycle in found]
        together = [cycle.together for cycle in found]
        states("in phase differs most", f"{case}, {axis}", together, changes)


def _cycles(pair: Pair, axis: str) -> list[HalfCycle]:
    """Return the half cycles of the deck along an axis."""
    friction, plain = (histories_of(result) for result in pair)
    moved, moved_plain = (
        np.column_stack([table["deck_ux_m"], table["deck_uy_m"]]) for table in (friction, plain)
    )
    walls = [
        table[f"abutment_{side}_wall_kn"] > 0.0 for table in (friction, plain) for side in _SIDES
    ]
    return half_cycles(plain["t_s"], moved_plain, moved, "xy".index(axis), walls)


def _history_change(pair: Pair, column: str) -> float:
    """Return the RMS change of a history by friction over its RMS without."""
    friction, plain = (histories_of(result)[column] for result in pair)
    return float(rms_change(friction, plain))


def _key_changes(result: AnalysisResult) -> int:
    """Return how often the keys change from sticking to slipping or back."""
    table = histories_of(result)
    normal, friction_1, friction_2 = (
        np.column_stack([table[name] for name in table if "key" in name and name.endswith(ending)])
        for ending in ("_normal_kn", "_friction_1_kn", "_friction_2_kn")
    )
    return stick_slip_changes(normal, np.hypot(friction_1, friction_2), FRICTION_PCT / 100)


def _displacement_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw the displacement of the mass centre along both axes."""
    figure, axes = style.time_panels("longitudinal (mm)", "transverse (mm)", height_in=3.8)
    tables = [histories_of(result) for result in pair]
    for axis, column in zip(axes, ("deck_ux_m", "deck_uy_m"), strict=True):
        _draw_pair(axis, [(table["t_s"], table[column] / MM) for table in tables])
    style.legend(axes[0], loc="upper right")
    figure.suptitle(f"OSB1, mass centre, skew 0; {motion.label}", fontsize=9)
    return figure


def _hysteresis_figure(pair: Pair, motion: PaperMotion) -> Figure:
    """Draw force against displacement of both abutments along both axes."""
    figure, axes = style.panels(2, 2, height_in=5.0)
    tables = [histories_of(result) for result in pair]
    for row, (axis_name, direction) in enumerate(_AXES.items()):
        for axis, side in zip(axes[row], _SIDES, strict=True):
            start = f"abutment_{side}_{direction}"
            curves = [(t[f"{start}_m"] / MM, t[f"{start}_kn"] * KN / 1e6) for t in tables]
            _draw_pair(axis, curves)
            style.label(axis, "displacement (mm)", "force (MN)", f"{side} abutment, {axis_name}")
    style.legend(axes[0, 0], loc="best")
    figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)
    return figure


def _cycle_figure(cycles: list[HalfCycle], motion: PaperMotion) -> Figure:
    """Draw the change by friction per half cycle against how much the axes coincide."""
    figure, axis = style.panel(height_in=3.0)
    for has_contact, colour, text in (
        (True, style.BLUE, "backwall in contact"),
        (False, style.ORANGE, "no backwall contact"),
    ):
        chosen = [cycle for cycle in cycles if cycle.has_contact is has_contact]
        change_mm = [(cycle.peak_with_m - cycle.peak_without_m) / MM for cycle in chosen]
        together = [cycle.together for cycle in chosen]
        style.dots(axis, together, change_mm, colour, text, ms=5, alpha=0.8)
    axis.axhline(0.0, color="0.4", lw=0.6)
    x = "both axes together: max |ux uy| of the half cycle / (max |ux| max |uy|)"
    style.label(axis, x, "change of transverse\npeak by friction (mm)")
    style.legend(axis)
    figure.suptitle(f"OSB1, skew 0, transverse half cycles; {motion.label}", fontsize=9)
    return figure


def run_places(study: Study) -> None:
    """Run the study of friction at walls, keys or both."""
    record = waho()
    rows: list[dict[str, Any]] = []
    for skew, motion in product(SKEWS_DEG, record.runs()):
        variant = paper_variant(skew_deg=skew)
        runs = {
            place: analysis(variant, motion, options=ModelOptions(friction_at=place))
            for place in PLACES
        }
        runs["none"] = analysis(paper_variant(skew_deg=skew, friction_pct=0), motion)
        changes = (
            _history_change((runs[place], runs["none"]), "deck_uy_m") for place in ("walls", "keys")
        )
        case = f"OSB1, skew {skew}{record.stand_in}"
        met = _has_wall_force(runs.values(), skew)
        study.states("backwall makes it", case, *changes, run=motion.run, premise=met)
        if not motion.is_nominal:
            continue
        _check_places(study, skew, runs)
        plain = runs["none"].whole_history
        for place, demand in product(PLACES, _PLACE_DEMANDS):
            if plain[demand] > _LEAST.get(demand, 0.0):
                value = runs[place].whole_history[demand]
                text = f"skew {skew}, friction at {place}: {demand}"
                study.report(text, value, plain[demand], _WITHOUT)
                names = {"skew_deg": skew, "friction_at": place, "demand": demand}
                rows.append(names | {"value": value, "without": plain[demand]})
    table = pd.DataFrame(rows)
    study.tables["changes"] = table.assign(change=table["value"] / table["without"] - 1.0)
    study.figures["changes"] = _place_figure(study.tables["changes"], record)


def _check_places(study: Study, skew: int, runs: dict[FrictionAt | str, AnalysisResult]) -> None:
    """Check that the analyses ran, and that contacts without friction carry none."""
    has_run = all(found.status in RAN for found in runs.values())
    text = f"skew {skew}: every analysis ends with status ok or collapse"
    study.holds(text, truth=has_run, source="this model")
    for place, free in _FREE.items():
        forces = [
            float(np.abs(column).max())
            for name, column in histories_of(runs[place]).items()
            if free in name and name.endswith(("friction_1_kn", "friction_2_kn"))
        ]
        text = f"skew {skew}, friction at {place}: friction at a {free} (kN)"
        study.at_most(text, max(forces, default=0.0), 0.0, "no friction there")


def _place_figure(table: pd.DataFrame, motion: PaperMotion) -> Figure:
    """Draw the change of each demand by the place of friction."""
    figure, axes = style.panels(1, len(SKEWS_DEG), height_in=3.4, sharey=True)
    colours = (style.BLACK, style.BLUE, style.ORANGE)
    names = list(_PLACE_DEMANDS)
    for axis, skew in zip(axes[0], SKEWS_DEG, strict=True):
        for number, (place, colour) in enumerate(zip(PLACES, colours, strict=True)):
            rows = table[(table["skew_deg"] == skew) & (table["friction_at"] == place)]
            heights = [names.index(demand) + 0.25 * (number - 1) for demand in rows["demand"]]
            axis.barh(heights, 100.0 * rows["change"], height=0.22, color=colour, label=place)
        axis.axvline(0.0, color=style.BLACK, lw=0.6)
        axis.set_yticks(range(len(names)), list(_PLACE_DEMANDS.values()))
        style.label(axis, "change by friction (%)", "", f"skew {skew}")
    axes[0, 0].invert_yaxis()
    style.legend(axes[0, 0], title="friction at", title_fontsize=7)
    figure.suptitle(f"OSB1, friction 0.5; {motion.label}", fontsize=9)
    return figure


def run_models(study: Study) -> None:
    """Run OSB1 with all abutment models, straight and skewed, and OSB2S with friction."""
    motion = waho()
    runs = {
        (abutment, skew): analysis(paper_variant(abutment=abutment, skew_deg=skew), motion)
        for abutment in _MODEL_COLOURS
        for skew in SKEWS_DEG
    }
    text = "OSB1: every abutment model and skew ends with status ok or collapse"
    has_run = all(found.status in RAN for found in runs.values())
    study.holds(text, truth=has_run, source="this model")
    for run in motion.runs():
        for abutment in (name for name, traits in ABUTMENTS.items() if traits.has_contacts):
            pair = [
                runs[abutment, skew]
                if run.is_nominal
                else analysis(paper_variant(abutment=abutment, skew_deg=skew), run)
                for skew in SKEWS_DEG
            ]
            _judge_skew(partial(study.states, run=run.run), abutment, motion, pair)
    rough, smooth = (
        analysis(paper_variant(bridge="osb2s", skew_deg=20, friction_pct=friction_pct), motion)
        for friction_pct in (FRICTION_PCT, 0)
    )
    for demand in _MODEL_DEMANDS:
        text = f"OSB2S (surrogate), skew 20: {demand}, friction 0.5 against 0"
        study.report(text, rough.whole_history[demand], smooth.whole_history[demand], _WITHOUT)
    for skew in SKEWS_DEG:
        found = {abutment: runs[abutment, skew] for abutment in _MODEL_COLOURS}
        study.figures[f"skew{skew:02d}"] = _model_figure(found, skew, motion)
    study.tables["demands"] = pd.DataFrame(
        [
            {"abutment": abutment, "skew_deg": skew, "status": result.status}
            | {demand: result.whole_history[demand] for demand in _MODEL_DEMANDS}
            for (abutment, skew), result in runs.items()
        ]
    )


def _judge_skew(
    states: Callable[..., None], abutment: str, motion: PaperMotion, pair: Sequence[AnalysisResult]
) -> None:
    """Judge the statements on skew from a straight and a skewed bridge.

    Their premise is that an obtuse corner of the skewed deck hits its wall.
    """
    straight, skewed = (result.whole_history for result in pair)
    histories = histories_of(pair[1])
    # the last point of a wall is at the obtuse corner of a positive skew
    names = [f"{side} backwall {ModelOptions().backwall_points}" for side in _SIDES]
    hits = max(float(histories[f"{contact_column(name)}_normal_kn"].max()) for name in names) > 0.0
    case = f"OSB1, {abutment}, skew {SKEWS_DEG[1]}{motion.stand_in}"
    turns = (1e3 * found["deck_rotation_rad"] for found in (skewed, straight))
    states("skew bridge rotates", case, *turns, premise=hits)
    unseating = skewed["unseating_m"], straight["unseating_m"]
    acute_m = skewed["acute_corner_unseating_m"]
    states("acute corner leads", case, acute_m, unseating[0], premise=hits)
    states("skew needs longer seats", case, *unseating, premise=hits)


def _model_figure(runs: dict[str, AnalysisResult], skew: int, motion: PaperMotion) -> Figure:
    names = ("longitudinal (mm)", "transverse (mm)", "rotation (mrad)")
    figure, axes = style.time_panels(*names, height_in=5.4)
    columns = {"deck_ux_m": MM, "deck_uy_m": MM, "deck_rot_rad": 1e-3}
    for axis, (column, unit) in zip(axes, columns.items(), strict=True):
        for abutment, colour in _MODEL_COLOURS.items():
            table = histories_of(runs[abutment])
            text = abutment.replace("_", " ")
            style.line(axis, table["t_s"], table[column] / unit, colour, text, lw=0.9)
        axis.axhline(0.0, color=style.BLACK, lw=0.4)
    style.legend(axes[0], loc="upper right", ncols=5)
    figure.suptitle(f"OSB1, skew {skew}; {motion.label}", fontsize=9)
    return figure
