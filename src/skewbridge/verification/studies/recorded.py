"""An instrumented bridge in recorded earthquakes: model against recording.

The ground at each support is imposed on the model, and the motion of the deck is compared with its
recording in the band of `references.station`. Two predictions without a model are printed next to
it: the null, a deck that rides on its ends, and one motion at all supports. Changes of the model
show what the recording can decide.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, NamedTuple

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

type Histories = Mapping[str, Series]

DT_S: Final = 0.005
CM: Final = 0.01
#: Time before the strong part that is analysed, so that the model has forgotten its start.
_BEFORE_S: Final = 6.0
_AFTER_S: Final = 2.0


class Case(NamedTuple):
    """A model of the bridge; with `uniform`, all supports have the motion of the bent."""

    variant: Variant
    options: ModelOptions
    uniform: bool = False

    @classmethod
    def of(cls, station: Station, bridge: str | None = None) -> "Case":
        """Return the model of a station, or of another bridge file, without changes."""
        axes = {name: getattr(station, name) for name in ("skew_deg", "gap_mm", "friction")}
        variant = Variant.at(bridge or station.bridge, "contact_friction", axes)
        return cls(variant, checked(ModelOptions, dict(station.model), station.title))


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """The strong part of an event, with recorded quantities and those of the null, by name.

    `part` are the samples of the strong part in those of `event`, which starts `_BEFORE_S` earlier.
    """

    event: Event
    part: slice
    recorded: Histories
    null: Histories


def recording_of(event: Event, station: Station) -> Recording:
    """Return the recording of an event, cut to its strong part and the time before it."""
    dt_s, accel = event.dt_s, event.accel_mps2
    strong = strong_part(accel[station.period[0]], dt_s)
    first, last = max(0, strong.start - round(_BEFORE_S / dt_s)), round(_AFTER_S / dt_s)

    def quantity(each: Quantity, weights: Mapping[int, float]) -> Series:
        moved = np.add.reduce([weight * accel[channel] for channel, weight in weights.items()])
        if each.to is None:
            return each.factor * in_band(moved, dt_s)[strong] / G_MPS2
        return each.factor * in_band(moved - accel[each.to], dt_s, -2)[strong] / CM

    known = [each for each in station.quantities if each.channel in accel]
    cut = {channel: values[first : strong.stop + last] for channel, values in accel.items()}
    return Recording(
        event=replace(event, accel_mps2=cut),
        part=slice(strong.start - first, strong.stop - first),
        recorded={each.name: quantity(each, {each.channel: 1.0}) for each in known},
        null={each.name: quantity(each, each.rides_on) for each in known},
    )


def predicted(
    recording: Recording, station: Station, case: Case, *, dt_s: float = DT_S
) -> Histories:
    """Return the quantities of a model in the strong part; raise `RuntimeError` if it fails."""
    event, step_s = recording.event, recording.event.dt_s
    motions = event.motions(station)
    bent = motions["bent 1"]
    if case.uniform:
        motions = dict.fromkeys(motions, bent)
    settings = AnalysisSettings(dt_s=dt_s, contact_dt_s=min(dt_s, DT_S))
    shaken = Excitation(motion=bent, supports=motions)
    result = analyse(case.variant, shaken, settings, case.options, histories=True)
    if result.histories is None or result.status != "ok":
        raise RuntimeError(f"{event.date}: {result.status} {'; '.join(result.messages)}")
    times_s, found = np.arange(bent.npts) * step_s, dict[str, Series]()
    for each in station.quantities:
        if each.name not in recording.recorded:
            continue
        disp = np.interp(times_s, result.histories["t_s"], result.histories[each.deck])
        if each.to is None:
            ground = motions[each.support].components["xy".index(each.axis)]
            moved = (in_band(disp, step_s, 2) + in_band(ground, step_s)) / G_MPS2
        else:
            moved = in_band(disp, step_s) / CM
        found[each.name] = moved[recording.part]
    return found


def changed_cases(station: Station, folder: Path) -> dict[str, Case]:
    """Return changes of the model, by name; changed bridges are written to a folder."""
    case = Case.of(station)
    variant, options, _ = case
    changed = {
        "uniform input": case._replace(uniform=True),
        "no skew": case._replace(variant=replace(variant, skew_deg=0.0)),
        "square bents": case._replace(options=replace(options, bent_skew="square")),
        "fixed bases": case._replace(options=replace(options, foundation="fixed")),
    }
    stiff_m4 = 100.0 * load_bridge(station.bridge).deck.inertia_transverse_m4
    files = {"rigid deck": f"deck: {{inertia_transverse_m4: {stiff_m4}}}"}
    both = load_bridge(station.bridge).ends.values()
    if len(ends := [end for end in both if isinstance(end, IntegralData)]) == 2:
        fill = np.prod([end.backfill.stiffness_mn_per_m for end in ends]) ** 0.5
        piles = np.prod([end.piles.lateral_kn_per_m for end in ends]) ** 0.5
        mean = f"{{backfill: {{stiffness_mn_per_m: {fill}}}, piles: {{lateral_kn_per_m: {piles}}}}}"
        files["equal ends"] = f"abutments: {{left: {mean}, right: {mean}}}"
    for name, text in files.items():
        path = folder / f"{name.replace(' ', '_')}.yaml"
        path.write_text(f"extends: {station.bridge}\nsource: 'd: {name}'\n{text}", encoding="utf-8")
        changed[name] = Case.of(station, str(path))
    if station.other:
        joint = Case.of(station, station.other)
        changed |= {"west end with a joint": joint} | {
            f"joint, {name}": joint._replace(variant=replace(joint.variant, **change))
            for name, change in {
                "friction 0": {"friction_pct": 0},
                "gap -50 %": {"gap_mm": 0.5 * station.gap_mm},
                "gap +50 %": {"gap_mm": 1.5 * station.gap_mm},
            }.items()
        }
    return changed


def comparison(found: Series, recorded: Series) -> dict[str, float]:
    """Return peak ratio, correlation (0 without motion) and normalised error of a history."""
    return {
        "peak_ratio": float(np.abs(found).max() / np.abs(recorded).max()),
        "correlation": float(np.corrcoef(found, recorded)[0, 1]) if found.any() else 0.0,
        "error": float(np.linalg.norm(found - recorded) / np.linalg.norm(recorded)),
    }


def run_painter(study: Study) -> None:
    """Compare the Painter Street overcrossing with the recordings in the folder of the study."""
    if study.records is None:
        study.say(f"{study.name}: skipped, it needs recordings: name a folder with --records DIR")
        return
    station = read_station("painter")
    rows: list[dict[str, Any]] = []
    with TemporaryDirectory(prefix="skewbridge-") as folder:
        cases = {"model": Case.of(station), **changed_cases(station, Path(folder))}
        for event in read_events(study.records, station):
            study.say("; ".join([f"{event.date} ...", *event.notes]))
            of = recording_of(event, station)
            models = {name: predicted(of, station, case) for name, case in cases.items()}
            models = {"model": models.pop("model"), "null": of.null, **models}
            _compare(study, station, of, models)
            study.figures[event.date] = histories_figure(of, models["model"])
            for name, found in models.items():
                table = {key: comparison(found[key], of.recorded[key]) for key in of.recorded}
                main = [e.name for e in station.quantities if e.peak and e.name in table]
                cost = np.sqrt(np.mean([table[key]["error"] ** 2 for key in main]))
                rows += [
                    {"event": event.date, "model": name, "cost": cost, "quantity": key} | agreement
                    for key, agreement in table.items()
                ]
    study.tables["rows"] = pd.DataFrame(study.comparisons)
    study.tables["changes"] = pd.DataFrame(rows)
    study.figures["changes"] = changes_figure(study.tables["changes"])


def _compare(
    study: Study, station: Station, recording: Recording, models: Mapping[str, Histories]
) -> None:
    """Add the comparisons of one event: peaks of all quantities, and the period."""
    event = recording.event
    kind = "fitted" if event.date in station.fitted else "predicted"
    for each in station.quantities:
        if (recorded := recording.recorded.get(each.name)) is None:
            continue
        found = {name: models[name][each.name] for name in ("model", "null", "uniform input")}
        peak = {name: float(np.abs(values).max()) for name, values in found.items()}
        model, null, uniform = (comparison(values, recorded) for values in found.values())
        least, most = each.peak.get(kind, (0.0, np.inf))
        reference = float(np.abs(recorded).max())
        source = f"channel {each.channel}, {kind}; peak ratio {least:g} to {most:g}"
        study.report(f"{event.date} {each.name} ({each.unit})", peak["model"], reference, source)
        study.comparisons[-1] |= {
            "pass": least <= model["peak_ratio"] <= most
            and model["correlation"] >= each.correlation.get(kind, -1.0)
            and model["error"] <= each.error.get(kind, np.inf),
            "tolerance": (most - 1.0) * reference if np.isfinite(most) else None,
            "event": event.date,
            "kind": kind,
            "null": peak["null"],
            "null_correlation": null["correlation"],
            "uniform": peak["uniform input"],
            "uniform_correlation": uniform["correlation"],
            "correlation": model["correlation"],
            "error": model["error"],
        }
    output, *inputs = station.period
    grounds = [in_band(event.accel_mps2[c], event.dt_s)[recording.part] for c in inputs]
    top = next(e.name for e in station.quantities if e.channel == output and e.to is None)
    own, model = (
        identified_period(of[top] * G_MPS2, np.column_stack(grounds), event.dt_s)
        for of in (recording.recorded, models["model"])
    )
    ground_g = max(float(np.abs(a).max()) for a in event.motions(station)["left"].components)
    source = f"halves +- {own.half_range_s:.3f} s; ground at the left end {ground_g / G_MPS2:.2f} g"
    within = max(0.1 * own.period_s, own.half_range_s)
    study.absolute(f"{event.date} period across (s)", model.period_s, own.period_s, within, source)
    study.comparisons[-1] |= {"event": event.date, "kind": kind, "half_range": own.half_range_s}


def histories_figure(recording: Recording, model: Histories) -> "Figure":
    """Return recorded and predicted histories of all quantities around the largest one."""
    event, part = recording.event, recording.part
    times_s, name = np.arange(part.start, part.stop) * event.dt_s, f"recorded {event.date}"
    middle_s = times_s[np.abs(next(iter(recording.recorded.values()))).argmax()]
    limits = {"xlim": (middle_s - 2.0, middle_s + 6.0)}
    panels: list[Panel] = []
    for quantity, recorded in recording.recorded.items():
        lines = {
            name: (times_s, recorded, {"color": "0.25", "lw": 1.3}),
            "predicted": (times_s, model[quantity], {"color": "C3", "lw": 0.9}),
        }
        unit = "cm" if "drift" in quantity or "ground" in quantity else "g"
        panels.append(Panel("time (s)", unit, lines, quantity, limits))
    return drawn(panels, columns=2, height_in=1.5 * ((len(panels) + 1) // 2) + 0.4)


def changes_figure(changes: pd.DataFrame) -> "Figure":
    """Return the error of each change of the model, one colour per event."""
    costs = changes.drop_duplicates(["event", "model"])
    names = list(dict.fromkeys(costs["model"]))[::-1]
    places, dots = np.arange(len(names)), {"marker": "o", "ls": "", "ms": 4}
    lines = {
        str(event): (rows.set_index("model")["cost"].reindex(names), places, dots)
        for event, rows in costs.groupby("event")
    }
    axes = {"yticks": places, "yticklabels": names, "xlim": (0.0, None)}
    return drawn([Panel("normalised error", "", lines, options=axes)], height_in=3.8)
