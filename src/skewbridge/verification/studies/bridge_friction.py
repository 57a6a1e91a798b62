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

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import pairwise, product
from math import radians
from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from skewbridge.analysis.abutment_history import AbutmentHistory, abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisScheme, AnalysisSettings
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.bridge.backfill import wall_backfill
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.geometry import contact_column
from skewbridge.report.run_figures import displacement_figure, hysteresis_figure
from skewbridge.statuses import RAN
from skewbridge.units import KJ, KN, MM, MN
from skewbridge.variant.options import FrictionAt, ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant
from skewbridge.verification.references.live_model import Array
from skewbridge.verification.registry import Study
from skewbridge.verification.statements import relative_change
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.paper_runs import (
    FRICTION_PCT,
    PaperMotion,
    paper_variant,
    tarzana,
    waho,
)

type Pair[Value] = tuple[Value, Value]
"""With friction, without."""
type States = Callable[..., None]
"""`Study.states` for one run of a case."""

DURATION_S: Final = 25.0
# Half cycles smaller than this share of the largest one are left out.
SMALLEST_CYCLE: Final = 0.15
# ASSUME friction at a wall can decide nothing while the deck pushes it with less than this share of
# the strength of its fill
LEAST_WALL_FORCE: Final = 0.05
_WITHOUT: Final = "without friction, this model"


def _is_pushed(least_kn: float, skew_deg: float) -> bool:
    """Return whether a wall force reaches a share of the strength of the fill of OSB1."""
    fill = wall_backfill(load_bridge("osb1").abutment, ModelOptions().backfill, radians(skew_deg))
    return least_kn > LEAST_WALL_FORCE * fill.ultimate_n / KN


def rms_change(with_friction: Array, without: Array) -> Array:
    """Return the RMS change by friction over the RMS without, over the first axis."""
    count = min(len(with_friction), len(without))
    change = with_friction[:count] - without[:count]
    return np.sqrt((change**2).mean(axis=0) / (without[:count] ** 2).mean(axis=0))


def stick_slip_changes(normal_n: Array, friction_n: Array, coefficient: float) -> int:
    """Return how often closed contacts change from sticking to slipping or back.

    Forces have the shape (n, units). From 98 % of its limit on a contact counts as slipping.
    """
    closed = normal_n > 0.0
    slipping = friction_n >= 0.98 * coefficient * normal_n
    stays = closed[1:] & closed[:-1]
    return int((stays & (slipping[1:] != slipping[:-1])).sum())


def half_cycles(
    t_s: Array, without_m: Array, with_m: Array, axis: int, in_contact: Sequence[NDArray[np.bool_]]
) -> pd.DataFrame:
    """Return the half cycles between zero crossings of a displacement without friction.

    Displacements along x and y have the shape (n, 2) without and (m, 2) with friction; only times
    of both runs count. The axis is 0 along x, 1 along y; `in_contact` has arrays that are true
    where a backwall carries force, in either run.

    Returns:
        start_s, end_s, the largest magnitudes peak_without_m and peak_with_m in this time, the
        relative change by friction, has_contact, and together: the largest product of both
        displacements at one time over the product of their largest of the run, 1 when both peaks
        coincide. Half cycles below `SMALLEST_CYCLE` are left out.
    """
    count = min(len(without_m), len(with_m))
    own, other = np.abs(without_m[:count, axis]), np.abs(without_m[:count, 1 - axis])
    closed = np.logical_or.reduce([flags[:count] for flags in in_contact])
    crossings = np.flatnonzero(np.diff(np.signbit(without_m[:count, axis]))) + 1
    rows: list[dict[str, float | bool]] = []
    for start, end in pairwise([0, *crossings.tolist(), count]):
        part = slice(start, end)
        without = float(own[part].max())
        if end - start < 2 or without < SMALLEST_CYCLE * own.max():
            continue
        rows.append(
            {
                "start_s": float(t_s[start]),
                "end_s": float(t_s[end - 1]),
                "peak_without_m": without,
                "peak_with_m": float(np.abs(with_m[part, axis]).max()),
                "together": float((own[part] * other[part]).max() / (own.max() * other.max())),
                "has_contact": bool(closed[part].any()),
            }
        )
    table = pd.DataFrame(rows)
    return table.assign(change=table["peak_with_m"] / table["peak_without_m"] - 1.0)


def _judge_cycles(states: States, statement: str, case: str, cycles: pd.DataFrame) -> None:
    """Judge whether friction lowers the peaks of the half cycles in contact."""
    changes = cycles.loc[cycles["has_contact"], "change"]
    states(statement, case, int((changes < 0.0).sum()), len(changes))


def _loop_figure(pair: Pair[AbutmentHistory], title: str) -> Figure:
    """Draw the force on the deck against its displacement along both axes, friction on top."""
    figure, axes = style.panels(1, 2, height_in=3.0)
    without_last = (1, style.ORANGE, "no friction"), (0, style.BLUE, "friction 0.5")
    for column, (axis, name) in enumerate(
        zip(axes.flat, ("longitudinal", "transverse"), strict=True)
    ):
        for number, colour, text in without_last:
            disp_m, force_n = pair[number].disp_m[:, column], pair[number].force_n[:, column]
            style.line(axis, disp_m / MM, force_n / MN, colour, text, lw=0.9)
        style.label(axis, "displacement (mm)", "force on the deck (MN)", name)
    style.legend(axes[0, 0], loc="best")
    figure.suptitle(title, fontsize=9)
    return figure


_ABUTMENT_SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
_KEYS: Final = ("sacrificial", "monolithic")  # the default model's first
PLACES: Final[tuple[FrictionAt, ...]] = ("all", "walls", "keys")
_FAST_HZ: Final = 5.0
_PUSH_M: Final = 0.09


def run_abutment(study: Study) -> None:
    """Run the study of figure 10."""
    record = tarzana()
    places: list[dict[str, Any]] = []
    for motion, keys, skew in product(record.runs(), _KEYS, _ABUTMENT_SKEWS_DEG):
        rough, smooth = (paper_variant(skew_deg=skew, friction_pct=f) for f in (FRICTION_PCT, 0))
        history = partial(_abutment, motion)
        pair = history(rough, keys=keys), history(smooth, keys=keys)
        case = f"skew {skew}, {keys} keys{record.stand_in}"
        met = _is_pushed(min(float(h.force_n[:, 0].max()) for h in pair) / KN, skew)
        states = partial(study.states, run=motion.run, premise=met)
        _judge_abutment(states, case, pair)
        if keys == _KEYS[0]:
            runs = {place: history(rough, friction_at=place) for place in PLACES[1:]}
            without = pair[1].disp_m
            changes = (float(rms_change(run.disp_m, without)[1]) for run in runs.values())
            states("backwall makes it", case, *changes)
            for place, run in ({"all": pair[0]} | runs).items():
                row = {"run": motion.run.name, "skew_deg": skew, "friction_at": place}
                peaks, plain = _peaks(run), _peaks(pair[1])
                row |= {name: relative_change(peaks[name], plain[name]) for name in peaks}
                for kind in ("backwall", "key"):
                    row[f"work at {kind}s (kJ)"] = _slip_kj(run, kind)
                places.append(row)
        if motion.is_nominal:
            plain = _peaks(pair[1])
            for quantity, value in _peaks(pair[0]).items():
                text = f"{case}: peak {quantity}, friction 0.5 against 0"
                study.report(text, value, plain[quantity], _WITHOUT)
            study.report(f"{case}: work of friction (kJ)", _slip_kj(pair[0]), 0.0, _WITHOUT)
            is_whole = all(history.is_complete for history in pair)
            text = f"{case}: both histories reach their end"
            study.holds(text, truth=is_whole, source="this model")
            label = f"skew{skew:02d}_{keys}"
            study.figures[label] = _loop_figure(pair, motion.label)
            study.tables[f"{label}_ledger"] = pd.DataFrame(
                [
                    {
                        "contact": unit.name,
                        "closures": unit.closures,
                        "contact_time_s": unit.contact_time_s,
                        "max_normal_kn": unit.max_normal_n / KN,
                        "max_friction_kn": unit.max_friction_n / KN,
                        "slip_work_kj": unit.slip_work_j / KJ,
                    }
                    for unit in pair[0].ledger
                ]
            )
    study.tables["places"] = pd.DataFrame(places)
    # a push along one axis without skew is independent of friction
    rough, smooth = paper_variant(), paper_variant(friction_pct=0)
    for axis, angle_deg in (("longitudinal", 0.0), ("transverse", 90.0)):
        push = partial(
            push_abutment, options=ModelOptions(), angle_deg=angle_deg, max_disp_m=_PUSH_M
        )
        exact_n = push(smooth).force_n
        change = float(np.abs(push(rough).force_n - exact_n).max() / np.abs(exact_n).max())
        study.states("static push", f"skew 0, {axis}", change)


def _abutment(motion: PaperMotion, variant: Variant, **options: Any) -> AbutmentHistory:
    settings = AnalysisSettings(duration_s=DURATION_S)
    excitation = Excitation(motion=motion.motion)
    return abutment_history(variant, excitation, settings, ModelOptions(**options))


def _slip_kj(history: AbutmentHistory, kind: str = "") -> float:
    return sum(unit.slip_work_j for unit in history.ledger if kind in unit.name) / KJ


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


def _judge_abutment(states: States, case: str, pair: Pair[AbutmentHistory]) -> None:
    """Judge the statements on the loops of one case with friction against those without."""

    def both(value: Callable[[AbutmentHistory], float]) -> list[float]:
        return [float(value(history)) for history in pair]

    def units(history: AbutmentHistory, kind: str) -> list[int]:
        return [index for index, name in enumerate(history.unit_names) if kind in name]

    for name, peaks in (
        ("into the fill", both(lambda h: h.disp_m[:, 0].max())),
        ("away from the fill", both(lambda h: (-h.disp_m[:, 0]).max())),
        ("force into the fill", both(lambda h: h.force_n[:, 0].max())),
    ):
        states("longitudinal hardly changes", f"{case}, {name}", *peaks)
    with_friction, without = pair
    keys = units(with_friction, "key")
    forces = with_friction.normals_n[:, keys], with_friction.friction_n[:, keys]
    states("keys stick and slip", case, stick_slip_changes(*forces, FRICTION_PCT / 100))
    states("fast vibration", case, *both(lambda h: _fast_rms(h.t_s, h.force_n[:, 0]) / KN))
    along, across = rms_change(with_friction.disp_m, without.disp_m).tolist()
    states("transverse differs more", f"{case}, RMS of the displacement", across, along)
    works = [[float(np.trapezoid(h.force_n[:, k], h.disp_m[:, k])) for h in pair] for k in (0, 1)]
    along, across = (abs(rough / smooth - 1.0) for rough, smooth in works)
    states("transverse differs more", f"{case}, work of the loops", across, along)
    closures = sum(unit.closures for unit in with_friction.ledger if "backwall" in unit.name)
    states("several contacts", case, closures)
    states("transverse peak", case, *both(lambda h: np.abs(h.disp_m[:, 1]).max()))
    walls = [(h.normals_n[:, units(h, "backwall")] > 0.0).any(axis=1) for h in pair]
    cycles = half_cycles(without.t_s, without.disp_m, with_friction.disp_m, 1, walls)
    _judge_cycles(states, "transverse cycles", case, cycles)


def _fast_rms(t_s: Array, force_n: Array) -> float:
    """Return the RMS of the frequencies above `_FAST_HZ`, on a regular grid of the same length."""
    grid_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    spectrum = np.fft.rfft(np.interp(grid_s, t_s, force_n))
    spectrum[np.fft.rfftfreq(len(grid_s), grid_s[1] - grid_s[0]) < _FAST_HZ] = 0.0
    return float(np.sqrt(np.mean(np.fft.irfft(spectrum, len(grid_s)) ** 2)))


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

_PLACE_DEMANDS: Final = (
    "column_shear_kn",
    "column_drift_ratio",
    "deck_disp_m",
    "deck_disp_y_m",
    "deck_rotation_rad",
    "unseating_m",
    "abutment_passive_m",
)
# Units without friction, by the place of friction.
_FREE: Final = {"walls": "key", "keys": "backwall"}
# A deck that does not turn has no rotation to compare with.
_LEAST: Final = {"deck_rotation_rad": 1e-4}

# The five models of the paper.
_MODELS: Final = ("roller", "simplified", "spring", "contact", "contact_friction")
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


def _analysis(
    motion: PaperMotion, variant: Variant, scheme: AnalysisScheme = "default", **options: Any
) -> AnalysisResult:
    """Return the analysis of a bridge under a motion, with its histories."""
    settings = AnalysisSettings(scheme=scheme, duration_s=DURATION_S)
    excitation = Excitation(motion=motion.motion)
    return analyse(variant, excitation, settings, ModelOptions(**options), histories=True)


def _histories(result: AnalysisResult) -> Mapping[str, Array]:
    return result.histories or {}


def _table(result: AnalysisResult) -> pd.DataFrame:
    return pd.DataFrame(_histories(result))


def _has_wall_force(runs: Iterable[AnalysisResult], skew_deg: int) -> bool:
    """Return whether the deck pushes a wall in every run with a share of its strength."""
    return _is_pushed(min(run.whole_history["backwall_force_kn"] for run in runs), skew_deg)


def run(study: Study) -> None:
    """Run the study of figures 11 and 12."""
    record = waho()
    for scheme, motion in product(SCHEMES, record.runs()):
        if scheme == "paper" and motion.run.scale is None:
            continue  # nine seconds an analysis: this scheme runs the record at its scales only
        rough, smooth = (
            _analysis(motion, paper_variant(friction_pct=f), scheme) for f in (FRICTION_PCT, 0)
        )
        pair = rough, smooth
        states = partial(study.states, run=motion.run, premise=_has_wall_force(pair, 0))
        case = f"{scheme} scheme{record.stand_in}"
        cycles = {axis: _cycles(pair, column) for axis, column in _AXES.items()}
        _judge(states, case, pair, cycles, same_record=motion.is_paper_record)
        if motion.is_nominal:
            _compare(study, f"{scheme} scheme", pair)
        if motion.is_nominal and scheme == SCHEMES[0]:
            study.tables["cycles"] = cycles["transverse"]
            runs = {"no friction": _table(smooth), "friction 0.5": _table(rough)}
            study.figures["displacements"] = displacement_figure(runs)
            study.figures["hysteresis"] = hysteresis_figure(runs)
            for figure in study.figures.values():
                figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)


def _compare(study: Study, case: str, pair: Pair[AnalysisResult]) -> None:
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


def _judge(
    states: States,
    case: str,
    pair: Pair[AnalysisResult],
    cycles: Mapping[str, pd.DataFrame],
    *,
    same_record: bool,
) -> None:
    """Judge the statements on the straight bridge with friction against the one without."""
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
    table = _histories(pair[0])
    normal, friction_1, friction_2 = (
        np.column_stack([table[name] for name in table if "key" in name and name.endswith(ending)])
        for ending in ("_normal_kn", "_friction_1_kn", "_friction_2_kn")
    )
    changes = stick_slip_changes(normal, np.hypot(friction_1, friction_2), FRICTION_PCT / 100)
    states("keys stick and slip", case, changes)
    for axis, found in cycles.items():
        sizes = (found["peak_with_m"] - found["peak_without_m"]).abs().tolist()
        states("in phase differs most", f"{case}, {axis}", found["together"].tolist(), sizes)


def _cycles(pair: Pair[AnalysisResult], axis: str) -> pd.DataFrame:
    """Return the half cycles of the deck along an axis."""
    friction, plain = (_histories(result) for result in pair)
    moved, moved_plain = (
        np.column_stack([table["deck_ux_m"], table["deck_uy_m"]]) for table in (friction, plain)
    )
    walls = [
        table[f"abutment_{side}_wall_kn"] > 0.0 for table in (friction, plain) for side in _SIDES
    ]
    return half_cycles(plain["t_s"], moved_plain, moved, "xy".index(axis), walls)


def _history_change(pair: Pair[AnalysisResult], column: str) -> float:
    """Return the RMS change of a history by friction over its RMS without."""
    friction, plain = (_histories(result)[column] for result in pair)
    return float(rms_change(friction, plain))


def run_places(study: Study) -> None:
    """Run the study of friction at walls, keys or both."""
    record = waho()
    rows: list[dict[str, Any]] = []
    for skew, motion in product(SKEWS_DEG, record.runs()):
        variant = paper_variant(skew_deg=skew)
        runs: dict[str, AnalysisResult] = {
            place: _analysis(motion, variant, friction_at=place) for place in PLACES
        }
        without = _analysis(motion, paper_variant(skew_deg=skew, friction_pct=0))
        changes = (_history_change((runs[place], without), "deck_uy_m") for place in _FREE)
        case = f"OSB1, skew {skew}{record.stand_in}"
        met = _has_wall_force([*runs.values(), without], skew)
        study.states("backwall makes it", case, *changes, run=motion.run, premise=met)
        if not motion.is_nominal:
            continue
        has_run = all(found.status in RAN for found in (*runs.values(), without))
        text = f"skew {skew}: every analysis ends with status ok or collapse"
        study.holds(text, truth=has_run, source="this model")
        for place, free in _FREE.items():
            forces = [
                float(np.abs(column).max())
                for name, column in _histories(runs[place]).items()
                if free in name and name.endswith(("friction_1_kn", "friction_2_kn"))
            ]
            text = f"skew {skew}, friction at {place}: friction at a {free} (kN)"
            study.at_most(text, max(forces, default=0.0), 0.0, "no friction there")
        plain = without.whole_history
        for place, demand in product(PLACES, _PLACE_DEMANDS):
            if plain[demand] > _LEAST.get(demand, 0.0):
                value = runs[place].whole_history[demand]
                text = f"skew {skew}, friction at {place}: {demand}"
                study.report(text, value, plain[demand], _WITHOUT)
                names = {"skew_deg": skew, "friction_at": place, "demand": demand}
                rows.append(names | {"value": value, "without": plain[demand]})
    table = pd.DataFrame(rows)
    study.tables["changes"] = table.assign(change=table["value"] / table["without"] - 1.0)


def run_models(study: Study) -> None:
    """Run OSB1 with all abutment models, straight and skewed, and OSB2S with friction."""
    motion = waho()
    runs = {
        (abutment, skew): _analysis(motion, paper_variant(abutment=abutment, skew_deg=skew))
        for abutment in _MODELS
        for skew in SKEWS_DEG
    }
    text = "OSB1: every abutment model and skew ends with status ok or collapse"
    has_run = all(found.status in RAN for found in runs.values())
    study.holds(text, truth=has_run, source="this model")
    for run in motion.runs():
        for abutment in (name for name, traits in ABUTMENTS.items() if traits.has_contacts):
            straight, skewed = (
                runs[abutment, skew]
                if run.is_nominal
                else _analysis(run, paper_variant(abutment=abutment, skew_deg=skew))
                for skew in SKEWS_DEG
            )
            case = f"OSB1, {abutment}, skew {SKEWS_DEG[1]}{motion.stand_in}"
            _judge_skew(partial(study.states, run=run.run), case, straight, skewed)
    rough, smooth = (
        _analysis(motion, paper_variant(bridge="osb2s", skew_deg=20, friction_pct=friction_pct))
        for friction_pct in (FRICTION_PCT, 0)
    )
    for demand in _MODEL_DEMANDS:
        text = f"OSB2S (surrogate), skew 20: {demand}, friction 0.5 against 0"
        study.report(text, rough.whole_history[demand], smooth.whole_history[demand], _WITHOUT)
    for skew in SKEWS_DEG:
        found = {model.replace("_", " "): _table(runs[model, skew]) for model in _MODELS}
        figure = study.figures[f"skew{skew:02d}"] = displacement_figure(found)
        figure.suptitle(f"OSB1, skew {skew}; {motion.label}", fontsize=9)
    study.tables["demands"] = pd.DataFrame(
        [
            {"abutment": abutment, "skew_deg": skew, "status": result.status}
            | {demand: result.whole_history[demand] for demand in _MODEL_DEMANDS}
            for (abutment, skew), result in runs.items()
        ]
    )


def _judge_skew(
    states: States, case: str, straight: AnalysisResult, skewed: AnalysisResult
) -> None:
    """Judge the statements on skew; their premise is that an obtuse corner hits its wall."""
    # the last point of a wall is at the obtuse corner of a positive skew
    corners = [f"{side} backwall {ModelOptions().backwall_points}" for side in _SIDES]
    normals = [_histories(skewed)[f"{contact_column(corner)}_normal_kn"] for corner in corners]
    judge = partial(states, premise=max(float(normal.max()) for normal in normals) > 0.0)
    peaks, plain = skewed.whole_history, straight.whole_history
    turns = (1e3 * found["deck_rotation_rad"] for found in (peaks, plain))
    judge("skew bridge rotates", case, *turns)
    judge("acute corner leads", case, peaks["acute_corner_unseating_m"], peaks["unseating_m"])
    judge("skew needs longer seats", case, peaks["unseating_m"], plain["unseating_m"])
