"""An instrumented bridge in recorded earthquakes: model against recording.

The ground at each support is imposed on the model, and the motion of the deck is compared with its
recording in the band `BAND_HZ`. Two predictions without a model are printed next to it: the null, a
deck that rides on its ends, and one motion at all supports. Changes of the model show what the
recording can decide.

The file of a station (`verification/stations/painter.yaml`) names the bridge, the channels that are
the ground of each support, and the quantities that are compared. Recordings are CSMIP files.
Channels are numbered by the station; a file may number them by recorder, so its header decides
(``STA CHN``).
"""

import calendar
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np
import pandas as pd
from pydantic import BaseModel

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats
from skewbridge.files.text import checked, merged, read_mapping, read_text
from skewbridge.motions.formats import Stated
from skewbridge.motions.read import read_trace
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.registry import Panel, Study, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

type Histories = Mapping[str, Floats]

#: Frequencies (Hz) of all comparisons. Below, the displacement of a record is a product of its
#: processing; above, the model has no modes that a record could decide.
BAND_HZ: Final = (0.5, 12.0)
#: Width of the ramps on both sides of the band / its limits.
_RAMP: Final = (0.8, 1.1)
#: Shares of the Arias intensity that begin and end the strong part of a recording.
_STRONG: Final = (0.02, 0.95)
_LEAD_S, _TAIL_S = 1.0, 2.0
MAX_V2_BYTES: Final = 50_000_000
_DATE = re.compile(
    rf"\b({'|'.join(calendar.month_abbr[1:])})[a-z]*\.? +(\d{{1,2}}), +(\d{{4}})", re.IGNORECASE
)
_STATION = re.compile(r"station +no\. *(\d+)", re.IGNORECASE)
_CHANNEL = re.compile(r"sta +chn: *(\d+)", re.IGNORECASE)
_RECORDER_CHANNEL = re.compile(r"chan *(\d+):", re.IGNORECASE)  # the same if none is stated
_TITLE = re.compile(r"^\s*corrected accelerogram.*$", re.IGNORECASE | re.MULTILINE)
_STATIONS: Final = Path(__file__).parents[1] / "stations"


class _Part(BaseModel, extra="forbid", frozen=True):
    pass


class Ground(_Part, frozen=True):
    """Channel of the ground along an axis of the bridge, and the one that replaces it if missing.

    `factor` is -1 for a channel that is positive against the axis.
    """

    channel: int
    factor: float = 1.0
    instead: int | None = None


class Quantity(_Part, frozen=True):
    """A compared quantity: an absolute acceleration (g), or a displacement to another channel (cm).

    Attributes:
        to: Channel of the ground that is subtracted.
        deck: Column of the histories with the motion of this place relative to its `support`.
        rides_on: Share of each ground channel in the motion of a deck that only rides on its ends.
        peak: Limits of predicted / recorded peak, for events that were fitted or predicted;
            likewise the least correlation and the largest normalised error.
    """

    name: str
    channel: int
    factor: float = 1.0
    to: int | None = None
    deck: str
    support: str
    rides_on: dict[int, float]
    peak: dict[str, tuple[float, float]] = {}
    correlation: dict[str, float] = {}
    error: dict[str, float] = {}

    @property
    def unit(self) -> str:
        """Unit in tables: g, or cm for a displacement."""
        return "g" if self.to is None else "cm"

    @property
    def axis(self) -> str:
        """Axis of the bridge, `x` or `y`."""
        return self.deck.removesuffix("_m")[-1]


class Station(_Part, frozen=True):
    """An instrumented bridge.

    Attributes:
        station: Number of the station in the headers.
        bridge: Name of its bridge in the catalogue, or a file in the folder of the stations.
        model: Modelling options of the site.
        uniform: Whether all supports have the motion of the bent.
        changes: Changed fields of each compared model, by its name.
        fitted: Dates of the events to which numbers of the bridge were fitted.
        ground: Ground of each support along x and y.
        period: Channel of the deck and those of the ground that identify the period.
    """

    station: str
    title: str
    bridge: str
    skew_deg: float
    gap_mm: float
    friction: float
    model: dict[str, Any] = {}
    uniform: bool = False
    changes: dict[str, dict[str, Any]] = {}
    fitted: tuple[str, ...] = ()
    ground: dict[str, dict[Literal["x", "y"], Ground]]
    period: tuple[int, ...]
    quantities: tuple[Quantity, ...]

    def changed(self, change: Mapping[str, Any]) -> "Station":
        """Return the station with changed fields; a nested mapping changes only its own fields."""
        return checked(Station, merged(self.model_dump(), change), self.title)

    @property
    def variant(self) -> Variant:
        """Variant of the bridge with the axes of the station."""
        axes = {name: getattr(self, name) for name in ("skew_deg", "gap_mm", "friction")}
        is_file = self.bridge.endswith(".yaml")
        bridge = str(_STATIONS / self.bridge) if is_file else self.bridge
        return Variant.at(bridge, "contact_friction", axes)

    @property
    def grounds(self) -> tuple[Ground, ...]:
        """Channels of the ground of all supports."""
        return tuple(ground for pair in self.ground.values() for ground in pair.values())

    @property
    def required(self) -> set[int]:
        """Channels without which nothing can be compared."""
        return {ground.channel for ground in self.grounds if not ground.instead} | {self.period[0]}


def read_station(name: str) -> Station:
    """Return a station of this package."""
    path = _STATIONS / f"{name}.yaml"
    return checked(Station, read_mapping(path), path)


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Recordings of one event at a station, cut to a common length.

    Attributes:
        date: Date in the headers, or the name of the folder.
        accel_mps2: Acceleration of each channel of the station, (n,).
        notes: What was replaced or left out.
    """

    date: str
    dt_s: float
    accel_mps2: Mapping[int, Floats]
    notes: tuple[str, ...] = ()

    def motions(self, station: Station) -> dict[str, GroundMotion]:
        """Return the ground motion of each support along x and y of the bridge."""
        return {
            support: GroundMotion(
                motion_id=f"{self.date} {support}",
                dt_s=self.dt_s,
                accel_1_mps2=pair["x"].factor * self.accel_mps2[pair["x"].channel],
                accel_2_mps2=pair["y"].factor * self.accel_mps2[pair["y"].channel],
                event=self.date,
                station=station.title,
            )
            for support, pair in station.ground.items()
        }


def read_events(folder: Path, station: Station) -> list[Event]:
    """Return the events in a folder: of its own files, or one per subfolder with files.

    Raises `InputError` for a folder without files, another station or missing channels.
    """
    folders = [folder, *(path for path in folder.glob("*") if path.is_dir())]
    files = {source: sorted(source.glob("*.[vV]2")) for source in folders}
    events = [_event(source, paths, station) for source, paths in files.items() if paths]
    if not events:
        raise InputError(f"{folder}: no .V2 file of an event, here or in its folders")
    return sorted(events, key=lambda event: event.date)


def _event(folder: Path, paths: list[Path], station: Station) -> Event:
    accels: dict[int, Floats] = {}
    steps_s: set[float] = set()
    date = folder.name
    for path in paths:
        text = read_text(path, MAX_V2_BYTES)
        headers = [text[title.start() :][:2500] for title in _TITLE.finditer(text)]
        for number, header in enumerate(headers, start=1):
            stated = _STATION.search(header)
            channel = _CHANNEL.search(header) or _RECORDER_CHANNEL.search(header)
            if stated is None or stated[1].lstrip("0") != station.station:
                text = f"station {stated[1]}" if stated else "no station number"
                value = f"{station.title} is station {station.station}"
                raise InputError(f"{path}: {text} in its header, but {value}")
            if channel is None or int(channel[1]) in accels:
                continue
            trace = read_trace(path, Stated(channel=number))
            accels[int(channel[1])] = trace.accel_mps2
            steps_s.add(trace.dt_s)
            if found := _DATE.search(header):
                date = f"{datetime.strptime(' '.join(found.groups()), '%b %d %Y'):%Y-%m-%d}"
    if missing := sorted(station.required - accels.keys()):
        lacking, value = (", ".join(map(str, c)) for c in (missing, sorted(station.required)))
        text = f"channel {lacking} of station {station.station} is missing"
        raise InputError(f"{folder}: {text}; the comparison needs {value}")
    if len(steps_s) > 1:
        steps = ", ".join(map(str, sorted(steps_s)))
        raise InputError(f"{folder}: time steps of {steps} s; all files must have the same")
    notes: list[str] = []
    for ground in station.grounds:
        if ground.channel not in accels and ground.instead is not None:
            accels[ground.channel] = accels[ground.instead]
            notes.append(f"channel {ground.instead} replaces channel {ground.channel}")
    absent = [quantity for quantity in station.quantities if quantity.channel not in accels]
    notes += [f"channel {quantity.channel} is missing: no {quantity.name}" for quantity in absent]
    # ASSUME recorders of one event start together; those of Painter Street do, within 6 ms
    count = min(values.size for values in accels.values())
    common = {channel: values[:count] for channel, values in sorted(accels.items())}
    return Event(date=date, dt_s=steps_s.pop(), accel_mps2=common, notes=tuple(notes))


def strong_part(accel: Floats, dt_s: float) -> slice:
    """Return the samples of the strong part of a recording, with a second before and two after."""
    energy = np.cumsum(accel**2) / np.sum(accel**2)
    start_row, end_row = np.searchsorted(energy, _STRONG)
    start = max(0, int(start_row - _LEAD_S / dt_s))
    return slice(start, min(len(accel), int(end_row + _TAIL_S / dt_s)))


def in_band(values: Floats, dt_s: float, derivative: int = 0) -> Floats:
    """Return a history in the band, differentiated ``derivative`` times (integrated if negative).

    It is filtered without phase shift; ramps of the filter are cosines of the logarithm.
    """
    count = len(values)
    trend = np.polynomial.Polynomial.fit(np.arange(count), values, 1)(np.arange(count))
    spectrum = np.fft.rfft(values - trend, 2 * count)
    frequency = np.fft.rfftfreq(2 * count, dt_s)
    frequency[0] = 1.0e-9
    low, high = BAND_HZ
    rise = np.log(frequency / (low * _RAMP[0])) / np.log(1.0 / _RAMP[0])
    fall = np.log(high * _RAMP[1] / frequency) / np.log(_RAMP[1])
    gain = np.prod([(1 - np.cos(np.pi * np.clip(ramp, 0, 1))) / 2 for ramp in (rise, fall)], axis=0)
    spectrum *= gain * (2j * np.pi * frequency) ** derivative
    return np.fft.irfft(spectrum, 2 * count)[:count]


class Period(NamedTuple):
    """Identified period, damping ratio and share of motion `explained` by the mode.

    `half_range_s` is the largest difference to the periods of the two halves of the recording.
    """

    period_s: float
    damping: float
    half_range_s: float
    explained: float


def identified_period(output: Floats, inputs: Floats, dt_s: float) -> Period:
    """Return the period of one mode that explains an acceleration from those of the supports.

    Output error of one mode with several inputs: the output is a sum of inputs and of responses of
    an oscillator to them. Only the period and damping of the oscillator are searched, the shares
    follow by least squares.

    Args:
        output: Acceleration, shape (n,), in the band.
        inputs: Accelerations, shape (n, supports), in the band.
        dt_s: Time step.
    """
    middle = len(output) // 2
    ranges = slice(None), slice(middle), slice(middle, None)
    (period_s, damping, unexplained), *halves = (
        _fitted_mode(output[samples], inputs[samples], dt_s) for samples in ranges
    )
    half_range_s = max(abs(half_s - period_s) for half_s, *_ in halves)
    return Period(period_s, damping, half_range_s, 1.0 - unexplained)


def _fitted_mode(output: Floats, inputs: Floats, dt_s: float) -> tuple[float, float, float]:
    """Return period (s) and damping ratio of a mode, and the share that it does not explain."""
    from scipy.optimize import minimize

    count = len(output)
    spectra = np.fft.rfft(inputs, 2 * count, axis=0)
    speed = 2 * np.pi * np.fft.rfftfreq(2 * count, dt_s)

    def left(values: Floats) -> float:
        """Return the share of the output that an oscillator does not explain."""
        period_s, damping = np.exp(values)
        omega = 2 * np.pi / period_s
        gain = speed**2 / (omega**2 - speed**2 + 2j * damping * omega * speed)
        responses = np.fft.irfft(spectra * gain[:, None], 2 * count, axis=0)[:count]
        columns = np.hstack([inputs, responses])
        explained = columns @ np.linalg.lstsq(columns, output, rcond=None)[0]
        return float(np.sum((output - explained) ** 2) / np.sum(output**2))

    starts = [np.log([period_s, 0.1]) for period_s in (0.18, 0.25, 0.32, 0.45)]
    limits = [tuple(np.log([0.1, 0.8])), tuple(np.log([0.01, 0.5]))]
    best = min(
        (minimize(left, start, method="Nelder-Mead", bounds=limits) for start in starts),
        key=lambda result: result.fun,
    )
    period_s, damping = np.exp(best.x).tolist()
    return period_s, damping, float(best.fun)


# ---- The model against the recordings

DT_S: Final = 0.005
CM: Final = 0.01
#: Time before the strong part that is analysed, so that the model has forgotten its start.
_BEFORE_S: Final = 6.0
_AFTER_S: Final = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Strong part of an event: quantities as recorded, and of a deck that rides on ends (`null`).

    `part` is the strong part as a slice of samples of `event`, which starts `_BEFORE_S` earlier.
    """

    event: Event
    part: slice
    recorded: Histories
    null: Histories


def recording_of(event: Event, station: Station) -> Recording:
    """Return the recording of an event, cut to its strong part and the time before it."""
    dt_s, accel = event.dt_s, event.accel_mps2
    strong = strong_part(accel[station.period[0]], dt_s)
    start, after = max(0, strong.start - round(_BEFORE_S / dt_s)), round(_AFTER_S / dt_s)

    def quantity(compared: Quantity, weights: Mapping[int, float]) -> Floats:
        accel_mps2 = np.add.reduce([weight * accel[channel] for channel, weight in weights.items()])
        if compared.to is None:
            return compared.factor * in_band(accel_mps2, dt_s)[strong] / G_MPS2
        return compared.factor * in_band(accel_mps2 - accel[compared.to], dt_s, -2)[strong] / CM

    available = [item for item in station.quantities if item.channel in accel]
    accel_cut = {channel: values[start : strong.stop + after] for channel, values in accel.items()}
    return Recording(
        event=replace(event, accel_mps2=accel_cut),
        part=slice(strong.start - start, strong.stop - start),
        recorded={item.name: quantity(item, {item.channel: 1.0}) for item in available},
        null={item.name: quantity(item, item.rides_on) for item in available},
    )


def predicted(recording: Recording, station: Station, *, dt_s: float = DT_S) -> Histories:
    """Return the quantities of the model in the strong part; raise `RuntimeError` if it fails."""
    event, step_s = recording.event, recording.event.dt_s
    motions = event.motions(station)
    bent = motions["bent 1"]
    if station.uniform:
        motions = dict.fromkeys(motions, bent)
    settings = AnalysisSettings(dt_s=dt_s, contact_dt_s=min(dt_s, DT_S))
    shaken = Excitation(motion=bent, supports=motions)
    options = checked(ModelOptions, station.model, station.title)
    result = analyse(station.variant, shaken, settings, options, histories=True)
    if result.histories is None or result.status != "ok":
        raise RuntimeError(f"{event.date}: {result.status} {'; '.join(result.messages)}")
    times_s, histories = np.arange(bent.npts) * step_s, dict[str, Floats]()
    for quantity in station.quantities:
        if quantity.name not in recording.recorded:
            continue
        disp = np.interp(times_s, result.histories["t_s"], result.histories[quantity.deck])
        if quantity.to is None:
            ground = motions[quantity.support].components["xy".index(quantity.axis)]
            deck_history = (in_band(disp, step_s, 2) + in_band(ground, step_s)) / G_MPS2
        else:
            deck_history = in_band(disp, step_s) / CM
        histories[quantity.name] = deck_history[recording.part]
    return histories


def comparison(history: Floats, recorded: Floats) -> dict[str, float]:
    """Return peak ratio, correlation (0 without motion) and normalised error of a history."""
    return {
        "peak_ratio": float(np.abs(history).max() / np.abs(recorded).max()),
        "correlation": float(np.corrcoef(history, recorded)[0, 1]) if history.any() else 0.0,
        "error": float(np.linalg.norm(history - recorded) / np.linalg.norm(recorded)),
    }


def run_painter(study: Study) -> None:
    """Compare the Painter Street overcrossing with the recordings in the folder of the study."""
    if study.records is None:
        study.report_progress(f"{study.name}: skipped without recordings (--records DIR)")
        return
    station = read_station("painter")
    cases = {name: station.changed(change) for name, change in station.changes.items()}
    rows: list[dict[str, Any]] = []
    for event in read_events(study.records, station):
        study.report_progress("; ".join([f"{event.date} ...", *event.notes]))
        data = recording_of(event, station)
        models = {"model": predicted(data, station), "null": data.null}
        models |= {name: predicted(data, case) for name, case in cases.items()}
        _compare(study, station, data, models)
        study.figures[event.date] = histories_figure(data, models["model"])
        for name, histories in models.items():
            table = {k: comparison(histories[k], data.recorded[k]) for k in data.recorded}
            with_limits = [q.name for q in station.quantities if q.peak and q.name in table]
            cost = np.sqrt(np.mean([table[key]["error"] ** 2 for key in with_limits]))
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
    for item in station.quantities:
        if (recorded := recording.recorded.get(item.name)) is None:
            continue
        predictions = {name: models[name][item.name] for name in ("model", "null", "uniform input")}
        peak = {name: float(np.abs(values).max()) for name, values in predictions.items()}
        model, null, uniform = (comparison(values, recorded) for values in predictions.values())
        lowest, highest = item.peak.get(kind, (0.0, np.inf))
        reference = float(np.abs(recorded).max())
        source = f"channel {item.channel}, {kind}; peak ratio {lowest:g} to {highest:g}"
        study.report(f"{event.date} {item.name} ({item.unit})", peak["model"], reference, source)
        limits = {
            "peak_ratio": (lowest, highest),
            "correlation": (item.correlation.get(kind, -1.0), 1.0),
            "error": (0.0, item.error.get(kind, np.inf)),
        }
        missed = [
            f"{name.replace('_', ' ')} {model[name]:.2f}, limits {low:g} to {high:g}"
            for name, (low, high) in limits.items()
            if not low <= model[name] <= high
        ]
        study.comparisons[-1] |= {
            "pass": not missed,
            "missed": "; ".join(missed),
            "tolerance": (highest - 1.0) * reference if np.isfinite(highest) else None,
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
    grounds = [in_band(event.accel_mps2[channel], event.dt_s)[recording.part] for channel in inputs]
    deck = next(q.name for q in station.quantities if q.channel == output and q.to is None)
    mode, model = (
        identified_period(histories[deck] * G_MPS2, np.column_stack(grounds), event.dt_s)
        for histories in (recording.recorded, models["model"])
    )
    ground_g = max(float(np.abs(a).max()) for a in event.motions(station)["left"].components)
    source = f"halves +- {mode.half_range_s:.3f} s; ground at left end {ground_g / G_MPS2:.2f} g"
    margin = max(0.1 * mode.period_s, mode.half_range_s)
    study.absolute(f"{event.date} period across (s)", model.period_s, mode.period_s, margin, source)
    study.comparisons[-1] |= {"event": event.date, "kind": kind, "half_range": mode.half_range_s}


def histories_figure(recording: Recording, model: Histories) -> "Figure":
    """Return recorded and predicted histories of all quantities around the largest one."""
    event, strong = recording.event, recording.part
    times_s, name = np.arange(strong.start, strong.stop) * event.dt_s, f"recorded {event.date}"
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
    y, dots = np.arange(len(names)), {"marker": "o", "ls": "", "ms": 4}
    lines = {
        str(event): (rows.set_index("model")["cost"].reindex(names), y, dots)
        for event, rows in costs.groupby("event")
    }
    axes = {"yticks": y, "yticklabels": names, "xlim": (0.0, None)}
    return drawn([Panel("normalised error", "", lines, options=axes)], height_in=3.8)
