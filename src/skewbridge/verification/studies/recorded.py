"""An instrumented bridge in recorded earthquakes: model against recording.

The ground at each support is imposed on the model, and the motion of the deck is compared with its
recording in the band of `references.station`. Two predictions without a model are printed next to
it: the null, a deck that rides on its ends, and one motion at all supports. Changes of the model
show what the recording can decide.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pandas as pd

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import IntegralData
from skewbridge.files.text import checked
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.references.station import (
    Event,
    Period,
    Quantity,
    Series,
    Station,
    identified_period,
    in_band,
    read_events,
    read_station,
    strong_part,
)
from skewbridge.verification.registry import Panel, Study, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DT_S: Final = 0.005
CM: Final = 0.01
SKIPPED: Final = "skipped: it needs recordings, give their folder with --records DIR"
#: Time before the strong part that is analysed, so that the model has forgotten its start.
_BEFORE_S: Final = 6.0
_AFTER_S: Final = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A model of the bridge; with `uniform`, all supports have the motion of the bent."""

    bridge: str
    skew_deg: float
    gap_mm: float
    friction: float
    options: ModelOptions = field(default_factory=ModelOptions)
    uniform: bool = False

    @classmethod
    def of(cls, station: Station, bridge: str | None = None) -> "Case":
        """Return the model of a station without changes."""
        return cls(
            bridge=bridge or station.bridge,
            skew_deg=station.skew_deg,
            gap_mm=station.gap_mm,
            friction=station.friction,
            options=checked(ModelOptions, dict(station.model), station.title),
        )

    @property
    def variant(self) -> Variant:
        """Its variant."""
        axes = {"skew_deg": self.skew_deg, "gap_mm": self.gap_mm, "friction": self.friction}
        return Variant.at(self.bridge, "contact_friction", axes)


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """The strong part of an event and its quantities in the band, by name.

    Attributes:
        part: Samples of the strong part in those of `event`, which starts `_BEFORE_S` before it.
        recorded: Recorded quantities.
        null: Quantities of a deck that rides on its ends.
    """

    event: Event
    part: slice
    recorded: Mapping[str, Series]
    null: Mapping[str, Series]

    @property
    def times_s(self) -> Series:
        """Times of the strong part."""
        return np.arange(self.part.start, self.part.stop) * self.event.dt_s


def recording_of(event: Event, station: Station) -> Recording:
    """Return the recording of an event, cut to its strong part and the time before it."""
    dt_s, accel = event.dt_s, event.accel_mps2
    strong = strong_part(accel[station.period[0]], dt_s)
    first = max(0, strong.start - round(_BEFORE_S / dt_s))
    part = slice(strong.start - first, strong.stop - first)

    def quantity(each: Quantity, weights: Mapping[int, float]) -> Series:
        moved = sum(weight * accel[channel] for channel, weight in weights.items())
        if each.to is None:
            return each.factor * in_band(np.asarray(moved), dt_s)[strong] / G_MPS2
        return each.factor * in_band(moved - accel[each.to], dt_s, -2)[strong] / CM

    known = [each for each in station.quantities if each.channel in accel]
    last = strong.stop + round(_AFTER_S / dt_s)
    cut = {channel: values[first:last] for channel, values in accel.items()}
    return Recording(
        event=replace(event, accel_mps2=cut),
        part=part,
        recorded={each.name: quantity(each, {each.channel: 1.0}) for each in known},
        null={each.name: quantity(each, each.rides_on) for each in known},
    )


def predicted(
    recording: Recording, station: Station, case: Case, *, dt_s: float = DT_S
) -> dict[str, Series]:
    """Return the quantities of a model in the strong part; raise `RuntimeError` if it fails."""
    event, step_s = recording.event, recording.event.dt_s
    motions = event.motions(station)
    bent = next(name for name in motions if name.startswith("bent"))
    if case.uniform:
        motions = dict.fromkeys(motions, motions[bent])
    result = analyse(
        case.variant,
        Excitation(motion=motions[bent], supports=motions),
        AnalysisSettings(dt_s=dt_s, contact_dt_s=min(dt_s, DT_S)),
        case.options,
        histories=True,
    )
    if result.histories is None or result.status != "ok":
        raise RuntimeError(f"{event.date}: {result.status} {'; '.join(result.messages)}")
    times_s = np.arange(motions[bent].npts) * step_s
    found: dict[str, Series] = {}
    for each in station.quantities:
        if each.name not in recording.recorded:
            continue
        axis = "y" if "_y_" in each.deck or "_uy_" in each.deck else "x"
        disp = np.interp(times_s, result.histories["t_s"], result.histories[each.deck])
        ground = motions[each.support].components["xy".index(axis)]
        if each.to is None:
            accel = in_band(disp, step_s, 2) + in_band(ground, step_s)
            found[each.name] = accel[recording.part] / G_MPS2
        else:
            found[each.name] = in_band(disp, step_s)[recording.part] / CM
    return found


# --- changes of the model: what the recording can decide


def changed_cases(station: Station, folder: Path) -> dict[str, Case]:
    """Return changes of the model, by name; bridges of changed numbers are written to a folder."""
    case, data = Case.of(station), load_bridge(station.bridge)
    files = {"rigid deck": _stiff_deck(data.deck.inertia_transverse_m4)}
    if (ends := _equal_ends(station.bridge)) is not None:
        files["equal ends"] = ends
    changed: dict[str, Case] = {
        "uniform input": replace(case, uniform=True),
        "no skew": replace(case, skew_deg=0.0),
        "square bents": replace(case, options=replace(case.options, bent_skew="square")),
        "fixed bases": replace(case, options=replace(case.options, foundation="fixed")),
    }
    for name, text in files.items():
        path = folder / f"{name.replace(' ', '_')}.yaml"
        path.write_text(f"extends: {station.bridge}\nsource: 'd: {name}'\n{text}", encoding="utf-8")
        changed[name] = replace(case, bridge=str(path))
    if station.other:
        joint = replace(case, bridge=station.other)
        changed |= {
            "west end with a joint": joint,
            "joint, friction 0": replace(joint, friction=0.0),
            "joint, gap -50 %": replace(joint, gap_mm=0.5 * case.gap_mm),
            "joint, gap +50 %": replace(joint, gap_mm=1.5 * case.gap_mm),
        }
    return changed


def _stiff_deck(inertia_m4: float) -> str:
    return f"deck: {{inertia_transverse_m4: {100.0 * inertia_m4:.6g}}}\n"


def _equal_ends(bridge: str) -> str | None:
    """Return both ends with the geometric means of their stiffnesses, or None without such ends."""
    both = load_bridge(bridge).ends.values()
    ends = [end for end in both if isinstance(end, IntegralData)]
    if len(ends) < len(both):
        return None
    fill = np.prod([end.backfill.stiffness_mn_per_m for end in ends]) ** 0.5
    piles = np.prod([end.piles.lateral_kn_per_m for end in ends]) ** 0.5
    mean = f"{{backfill: {{stiffness_mn_per_m: {fill}}}, piles: {{lateral_kn_per_m: {piles}}}}}"
    return f"abutments:\n  left: {mean}\n  right: {mean}\n"


def comparison(found: Series, recorded: Series) -> dict[str, float]:
    """Return peak ratio, correlation and normalised error of a history."""
    is_moving = np.ptp(found) > 0.0
    return {
        "peak_ratio": float(np.abs(found).max() / np.abs(recorded).max()),
        "correlation": float(np.corrcoef(found, recorded)[0, 1]) if is_moving else 0.0,
        "error": float(np.linalg.norm(found - recorded) / np.linalg.norm(recorded)),
    }


def cost(found: Mapping[str, Series], recorded: Mapping[str, Series], station: Station) -> float:
    """Return the root mean square of the normalised errors of the quantities with limits."""
    errors = [
        comparison(found[each.name], recorded[each.name])["error"]
        for each in station.quantities
        if each.peak and each.name in recorded
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


# --- study


def run_painter(study: Study) -> None:
    """Compare the Painter Street overcrossing with the recordings in the folder of the study."""
    if study.records is None:
        if study.report_progress:
            study.report_progress(f"{study.name}: {SKIPPED}")
        return
    station = read_station("painter")
    events = read_events(study.records, station)
    rows: list[dict[str, Any]] = []
    with TemporaryDirectory(prefix="skewbridge-") as folder:
        cases = changed_cases(station, Path(folder))
        for event in events:
            if study.report_progress:
                study.report_progress("; ".join([f"{event.date} ...", *event.notes]))
            recording = recording_of(event, station)
            model = predicted(recording, station, Case.of(station))
            others = {name: predicted(recording, station, case) for name, case in cases.items()}
            _compare(study, station, recording, model, others["uniform input"])
            study.figures[event.date] = histories_figure(recording, model)
            for name, found in {"model": model, "null": recording.null, **others}.items():
                recorded = recording.recorded
                total = cost(found, recorded, station)
                rows += [
                    {"event": event.date, "model": name, "cost": total, "quantity": quantity}
                    | comparison(found[quantity], recorded[quantity])
                    for quantity in recorded
                ]
    study.tables["rows"] = pd.DataFrame(study.comparisons)
    study.tables["changes"] = pd.DataFrame(rows)
    study.figures["changes"] = changes_figure(study.tables["changes"])


def _compare(
    study: Study,
    station: Station,
    recording: Recording,
    model: Mapping[str, Series],
    uniform: Mapping[str, Series],
) -> None:
    """Add the comparisons of one event: peaks of all quantities, and the period."""
    event = recording.event
    kind = "fitted" if event.date in station.fitted else "predicted"
    for each in station.quantities:
        if (recorded := recording.recorded.get(each.name)) is None:
            continue
        value, reference = (float(np.abs(of).max()) for of in (model[each.name], recorded))
        found = comparison(model[each.name], recorded)
        least, most = each.peak.get(kind, (0.0, np.inf))
        passed = (
            least <= found["peak_ratio"] <= most
            and found["correlation"] >= each.correlation.get(kind, -1.0)
            and found["error"] <= each.error.get(kind, np.inf)
        )
        limits = f"{least:g} to {most:g} of the peak" if each.peak.get(kind) else "no limit"
        source = f"channel {each.channel}, {kind}; {limits}"
        name = f"{event.date} {each.name} ({each.unit})"
        study.report(name, value, reference, source)
        study.comparisons[-1] |= {
            "pass": passed,
            "tolerance": (most - 1.0) * reference if np.isfinite(most) else None,
            "event": event.date,
            "kind": kind,
            "null": float(np.abs(recording.null[each.name]).max()),
            "null_correlation": comparison(recording.null[each.name], recorded)["correlation"],
            "uniform": float(np.abs(uniform[each.name]).max()),
            "uniform_correlation": comparison(uniform[each.name], recorded)["correlation"],
            "correlation": found["correlation"],
            "error": found["error"],
        }
    of_record, of_model = periods(recording, station, model)
    within = max(0.1 * of_record.period_s, of_record.half_range_s)
    name = f"{event.date} period across (s)"
    source = f"one mode, halves +- {of_record.half_range_s:.3f} s; ground {peak_g(event):.2f} g"
    study.absolute(name, of_model.period_s, of_record.period_s, within, source)
    study.comparisons[-1] |= {
        "event": event.date,
        "kind": kind,
        "half_range": of_record.half_range_s,
        "damping": of_record.damping,
        "ground_g": peak_g(event),
    }


def peak_g(event: Event) -> float:
    """Return the largest acceleration (g) of all channels of an event that are used."""
    return max(float(np.abs(values).max()) for values in event.accel_mps2.values()) / G_MPS2


def periods(
    recording: Recording, station: Station, model: Mapping[str, Series]
) -> tuple[Period, Period]:
    """Return the identified periods of the recording and of the model, with the same inputs."""
    event, part = recording.event, recording.part
    output, *inputs = station.period
    ground = [in_band(event.accel_mps2[channel], event.dt_s)[part] for channel in inputs]
    name = next(e.name for e in station.quantities if e.channel == output and e.to is None)
    recorded, found = (
        identified_period(of[name] * G_MPS2, np.column_stack(ground), event.dt_s)
        for of in (recording.recorded, model)
    )
    return recorded, found


def histories_figure(recording: Recording, model: Mapping[str, Series]) -> "Figure":
    """Return recorded and predicted histories of all quantities around the largest one."""
    times_s, name = recording.times_s, f"recorded {recording.event.date}"
    first = next(iter(recording.recorded.values()))
    middle_s = times_s[np.abs(first).argmax()]
    panels = [
        Panel(
            "time (s)",
            "cm" if "drift" in quantity or "ground" in quantity else "g",
            {
                name: (times_s, recorded, {"color": "0.25", "lw": 1.3}),
                "predicted": (times_s, model[quantity], {"color": "C3", "lw": 0.9}),
            },
            quantity,
            {"xlim": (middle_s - 2.0, middle_s + 6.0)},
        )
        for quantity, recorded in recording.recorded.items()
    ]
    return drawn(panels, columns=2, height_in=1.5 * ((len(panels) + 1) // 2) + 0.4)


def changes_figure(changes: pd.DataFrame) -> "Figure":
    """Return the error of each change of the model, one line per event."""
    costs = changes.drop_duplicates(["event", "model"])
    names = list(dict.fromkeys(costs["model"]))[::-1]
    lines = {
        str(event): (
            rows.set_index("model")["cost"].reindex(names),
            np.arange(len(names)),
            {"marker": "o", "ls": "", "ms": 4},
        )
        for event, rows in costs.groupby("event")
    }
    axes = {"yticks": np.arange(len(names)), "yticklabels": names, "xlim": (0.0, None)}
    return drawn([Panel("normalised error", "", lines, options=axes)], height_in=3.8)
