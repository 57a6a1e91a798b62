"""Friction at the abutments of OSB1: figures 10 to 12, walls against keys, abutment models.

Figure 10 shows only the abutment, under Tarzana. The paper mentions skew 0 and 25 degrees and does
not name the kind of keys, so the study runs both skews, with sacrificial keys (as in the default
model) and with monolithic keys. Figures 11 and 12 have no skew; they are run with the default
scheme and with the paper's. Section 6 of the paper announces the comparison of abutment models. If
a record of the paper is missing, figures and cases of statements name the motion that replaces it.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import radians
from typing import Any, Final, NamedTuple

import numpy as np
import openseespy.opensees as ops
import pandas as pd
from numpy.typing import NDArray

from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisScheme, AnalysisSettings
from skewbridge.analysis.step_loop import StepLoop
from skewbridge.analysis.trace import Series, at_regular_steps
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.bridge.assembly import solver_log
from skewbridge.bridge.backfill import wall_backfill
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build_abutment, contact_column, domain
from skewbridge.contact.law import UnitLedger
from skewbridge.files.tables import Floats, Row
from skewbridge.report.run_figures import displacement_figure, hysteresis_figure
from skewbridge.statuses import RAN
from skewbridge.units import KJ, KN, MM, MN
from skewbridge.variant.options import FrictionAt, ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant
from skewbridge.verification.references.live_model import rms
from skewbridge.verification.registry import Panel, Study, drawn
from skewbridge.verification.statements import relative_change
from skewbridge.verification.studies.paper_runs import (
    FRICTION_PCT,
    PaperMotion,
    paper_record,
    paper_variant,
    waho,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHistory:
    """Response of an abutment at n regular times."""

    t_s: Series
    disp_m: Series  # displacement of the deck end along x and y since dead load, shape (n, 2)
    force_n: Series  # force on the deck, positive if it opposes positive displacement, shape (n, 2)
    normals_n: Series  # normal forces of the contact units, shape (n, units)
    friction_n: Series  # resultant friction forces of the contact units, shape (n, units)
    unit_names: tuple[str, ...]
    ledger: tuple[UnitLedger, ...]
    is_complete: bool  # whether the analysis reached its end


def abutment_history(
    variant: Variant, excitation: Excitation, settings: AnalysisSettings, options: ModelOptions
) -> AbutmentHistory:
    """Analyse the right abutment (with contacts) of a variant with its share of the deck mass.

    The deck end does not rotate; +x pushes into the backfill. Only dashpots, pads and soil damp.
    """
    ground = GroundInput(excitation, settings)
    rows: list[list[float]] = []
    with solver_log(None), domain():
        abutment = build_abutment(variant, settings.model_options(options))
        ground.apply(abutment.blueprint.tags)
        contacts, handle = abutment.blueprint.contacts, abutment.handle
        assert contacts is not None

        def read() -> None:
            force_n = np.sum([ops.eleForce(pad.element)[6:8] for pad in handle.bearings], axis=0)
            for unit in (*handle.wall_units, *handle.key_units):
                force_n = force_n - contacts.global_force_on_j(unit)[:2]
            friction_n = [float(np.hypot(*pair)) for pair in contacts.tangentials_n]
            row = ops.getTime(), *ops.nodeDisp(abutment.connector)[:2], *force_n
            rows.append([*row, *contacts.normals_n, *friction_n])

        loop = StepLoop(contacts, settings, longest_s=0.0)
        read()
        ending = loop.run(ground.steps, read)
    table, count = np.array(rows), len(contacts.units)
    table = table[at_regular_steps(table[:, 0], settings.dt_s)]
    return AbutmentHistory(
        t_s=table[:, 0],
        disp_m=table[:, 1:3] - table[0, 1:3],
        force_n=table[:, 3:5],
        normals_n=table[:, 5 : 5 + count],
        friction_n=table[:, 5 + count :],
        unit_names=tuple(unit.name for unit in contacts.units),
        ledger=tuple(contacts.ledger()),
        is_complete=ending.status == "ok",
    )


type Pair[Value] = tuple[Value, Value]
"""The value with friction, the value without."""
type States = Callable[..., None]
"""`Study.states` for one run of a case."""

DURATION_S: Final = 25.0
SMALLEST_CYCLE: Final = 0.15  # share of the largest half cycle
_WITHOUT: Final = "without friction, this model"
_AXES: Final = ("longitudinal", "transverse")
PLACES: Final[tuple[FrictionAt, ...]] = ("all", "walls", "keys")


class DeckMotion(NamedTuple):
    """Motion of the deck: displacements (x, y), shape (n, 2), and contact with a wall."""

    disp_m: Floats
    touches_wall: NDArray[np.bool_]


def _is_pushed(forces_kn: Iterable[float], skew_deg: float) -> bool:
    """Return whether every wall force exceeds 5 % of the strength of OSB1's backfill."""
    fill = wall_backfill(load_bridge("osb1").seat, ModelOptions().backfill, radians(skew_deg))
    # ASSUME below 5 % of the strength, friction at a wall is too small to judge a statement
    return min(forces_kn) > 0.05 * fill.ultimate_n / KN


def rms_change(with_friction: Floats, without_friction: Floats) -> Floats:
    """Return the RMS of the change by friction / RMS without friction, along the first axis."""
    count = min(len(with_friction), len(without_friction))
    change = with_friction[:count] - without_friction[:count]
    return np.sqrt((change**2).mean(axis=0) / (without_friction[:count] ** 2).mean(axis=0))


def stick_slip_changes(normal_n: Floats, friction_n: Floats, coefficient: float) -> int:
    """Return the number of changes between sticking and slipping of closed contacts.

    Forces have shape (n, units). A contact slips if its friction is at least 98 % of its limit.
    """
    closed = normal_n > 0.0
    slipping = friction_n >= 0.98 * coefficient * normal_n
    stays_closed = closed[1:] & closed[:-1]
    return int((stays_closed & (slipping[1:] != slipping[:-1])).sum())


def half_cycles(pair: Pair[DeckMotion], axis: int) -> pd.DataFrame:
    """Return the half cycles between zero crossings of the motion without friction.

    Only times that both runs reach are used; axis 0 is x, 1 is y. Half cycles with a peak below
    `SMALLEST_CYCLE` x the largest peak are left out.

    Returns:
        One row per half cycle with peak_without_m and peak_with_m (magnitudes), change (relative,
        by friction), has_contact (with a wall, in either run) and together: the largest |x| |y| /
        product of the peaks of the run; it is 1 if the peaks of x and y coincide.
    """
    count = min(len(motion.disp_m) for motion in pair)
    with_friction, without_mu = (motion.disp_m[:count] for motion in pair)
    disp, across = np.abs(without_mu[:, axis]), np.abs(without_mu[:, 1 - axis])
    columns = {
        "peak_without_m": disp,
        "peak_with_m": np.abs(with_friction[:, axis]),
        "together": disp * across / (disp.max() * across.max()),
        "has_contact": np.logical_or(*(motion.touches_wall[:count] for motion in pair)),
    }
    crossings = np.diff(np.signbit(without_mu[:, axis]), prepend=np.signbit(without_mu[0, axis]))
    groups = pd.DataFrame(columns).groupby(np.cumsum(crossings))
    is_large = (groups["peak_without_m"].max() >= SMALLEST_CYCLE * disp.max()) & (groups.size() > 1)
    cycles = groups.max()[is_large].reset_index(drop=True)  # has_contact: if any contact closes
    return cycles.assign(change=cycles["peak_with_m"] / cycles["peak_without_m"] - 1.0)


def _judge_cycles(judge: States, statement: str, case: str, cycles: pd.DataFrame) -> None:
    """Judge whether friction lowers the peaks of the half cycles in contact."""
    changes = cycles.loc[cycles["has_contact"], "change"]
    judge(statement, case, int((changes < 0.0).sum()), len(changes))


_ABUTMENT_SKEWS_DEG: Final = (0, 25)  # source: the paper, section 4 (both)
_KEYS: Final = ("sacrificial", "monolithic")  # the default model has the first


def run_abutment(study: Study) -> None:
    """Run the study of figure 10: one abutment with and without friction."""
    record = paper_record("Tarzana")
    rows: list[Row] = []
    for motion, keys, skew in product(record.runs(), _KEYS, _ABUTMENT_SKEWS_DEG):
        with_mu, no_mu = (paper_variant(skew_deg=skew, friction_pct=f) for f in (FRICTION_PCT, 0))
        ground, settings = Excitation(motion=motion.motion), AnalysisSettings(duration_s=DURATION_S)
        places = PLACES if keys == _KEYS[0] else PLACES[:1]
        options = {contacts: ModelOptions(keys=keys, friction_at=contacts) for contacts in places}
        runs = {p: abutment_history(with_mu, ground, settings, o) for p, o in options.items()}
        pair = runs["all"], abutment_history(no_mu, ground, settings, options["all"])
        case = f"skew {skew}, {keys} keys{record.stand_in}"
        premise = _is_pushed((float(h.force_n[:, 0].max()) / KN for h in pair), skew)
        judge = partial(study.states, run=motion.run, premise=premise)
        _judge_abutment(judge, case, pair)
        peaks_0 = _peaks(pair[1])
        if len(places) > 1:
            changes = (rms_change(runs[p].disp_m, pair[1].disp_m)[1] for p in places[1:])
            judge("backwall makes it", case, *map(float, changes))
            for contacts, run in runs.items():
                row: Row = {"run": motion.run.name, "skew_deg": skew, "friction_at": contacts}
                row |= {name: relative_change(p, peaks_0[name]) for name, p in _peaks(run).items()}
                row |= {f"work at {k}s (kJ)": _slip_kj(run, k) for k in ("backwall", "key")}
                rows.append(row)
        if not motion.is_nominal:
            continue
        for quantity, value in _peaks(pair[0]).items():
            text = f"{case}: peak {quantity}, friction 0.5 against 0"
            study.report(text, value, peaks_0[quantity], _WITHOUT)
        study.report(f"{case}: work of friction (kJ)", _slip_kj(pair[0]), 0.0, _WITHOUT)
        text, is_whole = f"{case}: both histories reach their end", all(h.is_complete for h in pair)
        study.holds(text, truth=is_whole, source="this model")
        loops = ("no friction", pair[1]), ("friction 0.5", pair[0])
        labels = "displacement (mm)", "force on the deck (MN)"
        panels = [
            Panel(*labels, {n: (h.disp_m[:, k] / MM, h.force_n[:, k] / MN) for n, h in loops}, axis)
            for k, axis in enumerate(_AXES)
        ]
        name = f"skew{skew:02d}_{keys}"
        study.figures[name] = drawn(panels, columns=2, height_in=3.0, title=motion.label)
    study.tables["places"] = pd.DataFrame(rows)
    # without skew, a push along one axis is independent of friction
    for axis, angle_deg in zip(_AXES, (0.0, 90.0), strict=True):
        push = partial(push_abutment, options=ModelOptions(), angle_deg=angle_deg, max_disp_m=0.09)
        force_n, exact_n = (push(paper_variant(friction_pct=f)).force_n for f in (FRICTION_PCT, 0))
        change = float(np.abs(force_n - exact_n).max() / np.abs(exact_n).max())
        study.states("static push", f"skew 0, {axis}", change)


def _slip_kj(history: AbutmentHistory, kind: str = "") -> float:
    return sum(unit.slip_work_j for unit in history.ledger if kind in unit.name) / KJ


def _peaks(history: AbutmentHistory) -> dict[str, float]:
    x_m, y_m = history.disp_m.T
    x_n, y_n = history.force_n.T
    return {
        "into the fill (m)": float(x_m.max()),
        "away from the fill (m)": float(-x_m.min()),
        "transverse (m)": float(np.abs(y_m).max()),
        "force into the fill (kN)": float(x_n.max()) / KN,
        "transverse force (kN)": float(np.abs(y_n).max()) / KN,
    }


def _judge_abutment(judge: States, case: str, pair: Pair[AbutmentHistory]) -> None:
    """Judge the statements on figure 10 in one case, from runs with and without friction."""
    with_friction, smooth = pair
    names = smooth.unit_names
    walls, keys = (np.array([kind in name for name in names]) for kind in ("backwall", "key"))
    peaks = [_peaks(history) for history in pair]
    for name in ("into the fill (m)", "away from the fill (m)", "force into the fill (kN)"):
        judge("longitudinal hardly changes", f"{case}, {name}", *(peak[name] for peak in peaks))
    judge("transverse peak", case, *(peak["transverse (m)"] for peak in peaks))
    forces = with_friction.normals_n[:, keys], with_friction.friction_n[:, keys]
    judge("keys stick and slip", case, stick_slip_changes(*forces, FRICTION_PCT / 100))
    judge("fast vibration", case, *(_fast_rms(h.t_s, h.force_n[:, 0]) / KN for h in pair))
    change_x, change_y = rms_change(with_friction.disp_m, smooth.disp_m).tolist()
    judge("transverse differs more", f"{case}, RMS of the displacement", change_y, change_x)
    works = [[float(np.trapezoid(h.force_n[:, k], h.disp_m[:, k])) for h in pair] for k in (0, 1)]
    change_x, change_y = (abs(value / base - 1.0) for value, base in works)
    judge("transverse differs more", f"{case}, work of the loops", change_y, change_x)
    closures = sum(unit.closures for unit in with_friction.ledger if "backwall" in unit.name)
    judge("several contacts", case, closures)
    touches = [(history.normals_n[:, walls] > 0.0).any(axis=1) for history in pair]
    frictional, frictionless = (DeckMotion(h.disp_m, t) for h, t in zip(pair, touches, strict=True))
    _judge_cycles(judge, "transverse cycles", case, half_cycles((frictional, frictionless), 1))


def _fast_rms(t_s: Floats, force_n: Floats) -> float:
    """Return the RMS of the force at 5 Hz and above, resampled to a regular grid."""
    grid_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    spectrum = np.fft.rfft(np.interp(grid_s, t_s, force_n))
    spectrum[np.fft.rfftfreq(len(grid_s), grid_s[1] - grid_s[0]) < 5.0] = 0.0
    return rms(np.fft.irfft(spectrum, len(grid_s)))


SCHEMES: Final[tuple[AnalysisScheme, ...]] = ("default", "paper")
SKEWS_DEG: Final = (0, 30)
_SIDES: Final = ("left", "right")
_DEMANDS: Final = (
    *("deck_disp_m", "deck_disp_x_m", "deck_disp_y_m", "deck_rotation_rad"),
    *("column_shear_kn", "column_drift_ratio", "unseating_m", "acute_corner_unseating_m"),
    *("bearing_disp_m", "abutment_passive_m", "backwall_force_kn", "shear_key_force_kn"),
)
# Contacts without friction, by the place of friction.
_FREE: Final = {"walls": "key", "keys": "backwall"}
# The five models of the paper.
_MODELS: Final = ("roller", "simplified", "spring", "contact", "contact_friction")


def _analysis(
    motion: PaperMotion, variant: Variant, scheme: AnalysisScheme = "default", **options: Any
) -> AnalysisResult:
    settings = AnalysisSettings(scheme=scheme, duration_s=DURATION_S)
    run = variant, Excitation(motion=motion.motion), settings, ModelOptions(**options)
    return analyse(*run, histories=True)


def _histories(result: AnalysisResult) -> Mapping[str, Floats]:
    return result.histories or {}


def _wall_forces(runs: Iterable[AnalysisResult]) -> list[float]:
    return [run.whole_history["backwall_force_kn"] for run in runs]


def _report_demands(study: Study, case: str, pair: Pair[AnalysisResult]) -> None:
    for demand in _DEMANDS:
        with_friction, smooth = (result.whole_history[demand] for result in pair)
        study.report(f"{case}: {demand}, friction 0.5 against 0", with_friction, smooth, _WITHOUT)


def run(study: Study) -> None:
    """Run the study of figures 11 and 12: OSB1 with and without friction."""
    record = waho()
    for scheme, motion in product(SCHEMES, record.runs()):
        if scheme == "paper" and motion.run.scale is None:
            continue  # nine seconds per analysis: this scheme runs only the scaled record
        with_mu, frictionless = pair = (
            _analysis(motion, paper_variant(), scheme),
            _analysis(motion, paper_variant(friction_pct=0), scheme),
        )
        judge = partial(study.states, run=motion.run, premise=_is_pushed(_wall_forces(pair), 0))
        _judge(judge, f"{scheme} scheme{record.stand_in}", pair, same_record=motion.is_paper_record)
        if not motion.is_nominal:
            continue
        name = f"{scheme} scheme"
        _report_demands(study, name, pair)
        study.report(f"{name}: slip_work_kj", with_mu.whole_history["slip_work_kj"], 0.0, _WITHOUT)
        is_whole = all(result.status == "ok" for result in pair)
        text = f"{name}: both analyses end with status ok"
        study.holds(text, truth=is_whole, source="this model")
        close = all(result.whole_history["backwall_force_kn"] > 0.0 for result in pair)
        study.holds(f"{name}: the backwalls close", truth=close, source="this motion")
        if scheme == SCHEMES[0]:
            results = {"no friction": frictionless, "friction 0.5": with_mu}
            runs = {name: pd.DataFrame(_histories(result)) for name, result in results.items()}
            study.figures["displacements"] = displacement_figure(runs)
            study.figures["hysteresis"] = hysteresis_figure(runs)
            for figure in study.figures.values():
                figure.suptitle(f"OSB1, skew 0; {motion.label}", fontsize=9)


def _judge(judge: States, case: str, pair: Pair[AnalysisResult], *, same_record: bool) -> None:
    with_friction, frictionless = (_deck_motion(_histories(result)) for result in pair)
    for number, axis in enumerate(_AXES):
        cycles = half_cycles((with_friction, frictionless), number)
        _judge_cycles(judge, "bridge cycles", f"{case}, {axis}", cycles)
        sizes = (cycles["peak_with_m"] - cycles["peak_without_m"]).abs().tolist()
        judge("in phase differs most", f"{case}, {axis}", cycles["together"].tolist(), sizes)
        change = _history_change(pair, f"deck_u{'xy'[number]}_m")
        judge("axes are coupled", f"{case}, {axis}", change)
    columns = ("deck_disp_m", "deck_disp_x_m", "deck_disp_y_m", "column_shear_kn")
    *disps, shears = [[result.whole_history[demand] for result in pair] for demand in columns]
    for name, peaks in zip(("resultant", *_AXES), disps, strict=True):
        judge("displacement is reduced", f"{case}, {name}", *peaks)
        judge("displacement by 2 to 3 percent", f"{case}, {name}", *peaks, same_record=same_record)
    judge("shear is reduced", case, *shears)
    judge("shear by as much", case, abs(relative_change(*shears) - relative_change(*disps[0])))
    for side in _SIDES:
        change_x, change_y = (_history_change(pair, f"abutment_{side}_{axis}_kn") for axis in "xy")
        judge("bridge transverse loops", f"{case}, {side} abutment", change_y, change_x)
    keys = pd.DataFrame(_histories(pair[0])).filter(like="key")
    names = ("normal", "friction_1", "friction_2")
    normal, *friction = (keys.filter(regex=f"_{name}_kn$").to_numpy() for name in names)
    changes = stick_slip_changes(normal, np.hypot(*friction), FRICTION_PCT / 100)
    judge("keys stick and slip", case, changes)


def _deck_motion(table: Mapping[str, Floats]) -> DeckMotion:
    walls = np.logical_or(*(table[f"abutment_{side}_wall_kn"] > 0.0 for side in _SIDES))
    return DeckMotion(np.column_stack([table["deck_ux_m"], table["deck_uy_m"]]), walls)


def _history_change(pair: Pair[AnalysisResult], column: str) -> float:
    with_friction, frictionless = (_histories(result)[column] for result in pair)
    return float(rms_change(with_friction, frictionless))


def run_places(study: Study) -> None:
    """Run the study of friction at walls, keys or both."""
    record = waho()
    for skew, motion in product(SKEWS_DEG, record.runs()):
        variant = paper_variant(skew_deg=skew)
        runs = {contacts: _analysis(motion, variant, friction_at=contacts) for contacts in PLACES}
        smooth = _analysis(motion, paper_variant(skew_deg=skew, friction_pct=0))
        changes = (_history_change((runs[contacts], smooth), "deck_uy_m") for contacts in _FREE)
        case, analyses = f"OSB1, skew {skew}{record.stand_in}", (*runs.values(), smooth)
        premise = _is_pushed(_wall_forces(analyses), skew)
        study.states("backwall makes it", case, *changes, run=motion.run, premise=premise)
        if not motion.is_nominal:
            continue
        all_ran = all(analysis.status in RAN for analysis in analyses)
        text = f"skew {skew}: every analysis ends with status ok or collapse"
        study.holds(text, truth=all_ran, source="this model")
        for contacts, frictionless_part in _FREE.items():
            histories = pd.DataFrame(_histories(runs[contacts]))
            forces_kn = histories.filter(regex=f"{frictionless_part}.*friction_[12]_kn$")
            text = f"skew {skew}, friction at {contacts}: friction at a {frictionless_part} (kN)"
            study.at_most(text, forces_kn.abs().to_numpy().max(), 0.0, "no friction there")
        for contacts, demand in product(PLACES, _DEMANDS):
            value, value_without = (run.whole_history[demand] for run in (runs[contacts], smooth))
            # a deck that does not rotate gives no reference for the ratio
            if value_without > (1e-4 if demand == "deck_rotation_rad" else 0.0):
                text = f"skew {skew}, friction at {contacts}: {demand}"
                study.report(text, value, value_without, _WITHOUT)


def run_models(study: Study) -> None:
    """Run OSB1 with all abutment models and skews, and OSB2S with and without friction."""
    motion = waho()
    runs = {
        (abutment, skew): _analysis(motion, paper_variant(abutment=abutment, skew_deg=skew))
        for abutment, skew in product(_MODELS, SKEWS_DEG)
    }
    text = "OSB1: every abutment model and skew ends with status ok or collapse"
    all_ran = all(analysis.status in RAN for analysis in runs.values())
    study.holds(text, truth=all_ran, source="this model")
    with_contacts = [name for name, traits in ABUTMENTS.items() if traits.has_contacts]
    for run, abutment in product(motion.runs(), with_contacts):
        straight, skewed = (
            runs[abutment, skew]
            if run.is_nominal
            else _analysis(run, paper_variant(abutment=abutment, skew_deg=skew))
            for skew in SKEWS_DEG
        )
        case = f"OSB1, {abutment}, skew {SKEWS_DEG[1]}{motion.stand_in}"
        _judge_skew(partial(study.states, run=run.run), case, straight, skewed)
    with_friction, frictionless = (
        _analysis(motion, paper_variant(bridge="osb2s", skew_deg=20, friction_pct=friction_pct))
        for friction_pct in (FRICTION_PCT, 0)
    )
    _report_demands(study, "OSB2S (surrogate), skew 20", (with_friction, frictionless))
    for skew in SKEWS_DEG:
        tables = [pd.DataFrame(_histories(runs[model, skew])) for model in _MODELS]
        names = [model.replace("_", " ") for model in _MODELS]
        figure = displacement_figure(dict(zip(names, tables, strict=True)))
        figure.suptitle(f"OSB1, skew {skew}; {motion.label}", fontsize=9)
        study.figures[f"skew{skew:02d}"] = figure
    rows = [
        {"abutment": abutment, "skew_deg": skew, "status": result.status}
        | {demand: result.whole_history[demand] for demand in _DEMANDS}
        for (abutment, skew), result in runs.items()
    ]
    study.tables["demands"] = pd.DataFrame(rows)


def _judge_skew(judge: States, case: str, straight: AnalysisResult, skewed: AnalysisResult) -> None:
    """Judge the statements on skew; their premise is that an obtuse corner hits its wall."""
    # for a positive skew the last point of a wall is at the obtuse corner
    corners = [f"{side} backwall {ModelOptions().backwall_points}" for side in _SIDES]
    normals = [_histories(skewed)[f"{contact_column(corner)}_normal_kn"] for corner in corners]
    judge = partial(judge, premise=max(float(normal.max()) for normal in normals) > 0.0)
    peaks, peaks_at_0 = skewed.whole_history, straight.whole_history
    rotations = (1e3 * peak["deck_rotation_rad"] for peak in (peaks, peaks_at_0))
    judge("skew bridge rotates", case, *rotations)
    judge("acute corner leads", case, peaks["acute_corner_unseating_m"], peaks["unseating_m"])
    judge("skew needs longer seats", case, peaks["unseating_m"], peaks_at_0["unseating_m"])
