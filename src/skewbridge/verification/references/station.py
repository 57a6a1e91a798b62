"""Recordings of an instrumented bridge: a file of its station, and CSMIP files of one event.

The file of a station (`verification/stations/painter.yaml`) names the bridge, the channels that are
the ground of each support, and the quantities that are compared. Channels are numbered by the
station; a file may number them by recorder, so its header decides (``STA CHN``).
"""

import calendar
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from skewbridge.errors import InputError
from skewbridge.files.text import checked, read_mapping, read_text
from skewbridge.motions.formats import Stated
from skewbridge.motions.read import read_trace
from skewbridge.motions.record import GroundMotion

type Series = NDArray[np.float64]

#: Frequencies (Hz) of all comparisons. Below, the displacement of a record is a product of its
#: processing; above, the model has no modes that a record could decide.
BAND_HZ: Final = (0.5, 12.0)
#: Width of the ramps on both sides of the band / its limits.
_RAMP: Final = (0.8, 1.1)
#: Shares of the Arias intensity that begin and end the strong part of a recording.
_STRONG: Final = (0.02, 0.95)
_LEAD_S, _TAIL_S = 1.0, 2.0
MAX_V2_BYTES: Final = 50_000_000
_MONTHS: Final = tuple(calendar.month_abbr)  # the first is empty
_DATE = re.compile(r"\b([A-Za-z]{3})[A-Za-z]*\.? +(\d{1,2}), +(\d{4})")
_STATION = re.compile(r"station +no\. *(\d+)", re.IGNORECASE)
_CHANNEL = re.compile(r"sta +chn: *(\d+)", re.IGNORECASE)
_RECORDER_CHANNEL = re.compile(r"chan *(\d+):", re.IGNORECASE)  # the same if none is stated
_TITLE = re.compile(r"^\s*corrected accelerogram.*$", re.IGNORECASE | re.MULTILINE)


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
        """Unit of the values in tables."""
        return "g" if self.to is None else "cm"

    @property
    def axis(self) -> str:
        """Axis of the bridge, `x` or `y`."""
        return self.deck.removesuffix("_m")[-1]


class Station(_Part, frozen=True):
    """An instrumented bridge.

    Attributes:
        station: Number of the station in the headers.
        bridge: Name of its bridge in the catalogue; `other` is another account of it.
        model: Modelling options of the site.
        fitted: Dates of the events to which numbers of the bridge were fitted.
        ground: Ground of each support along x and y.
        period: Channel of the deck and those of the ground that identify the period.
    """

    station: str
    title: str
    bridge: str
    other: str | None = None
    skew_deg: float
    gap_mm: float
    friction: float
    model: dict[str, Any] = {}
    fitted: tuple[str, ...] = ()
    ground: dict[str, dict[Literal["x", "y"], Ground]]
    period: tuple[int, ...]
    quantities: tuple[Quantity, ...]

    @property
    def grounds(self) -> tuple[Ground, ...]:
        """Channels of the ground of all supports."""
        return tuple(ground for pair in self.ground.values() for ground in pair.values())

    @property
    def required(self) -> set[int]:
        """Channels without which nothing can be compared."""
        return {each.channel for each in self.grounds if not each.instead} | {self.period[0]}


def read_station(name: str) -> Station:
    """Return a station of this package."""
    path = Path(__file__).parents[1] / "stations" / f"{name}.yaml"
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
    accel_mps2: Mapping[int, Series]
    notes: tuple[str, ...] = ()

    def motions(self, station: Station) -> dict[str, GroundMotion]:
        """Return the ground motion of each support along x and y of the bridge."""
        found: dict[str, GroundMotion] = {}
        for support, pair in station.ground.items():
            along, across = (
                ground.factor * self.accel_mps2[ground.channel] for ground in (pair["x"], pair["y"])
            )
            found[support] = GroundMotion(
                motion_id=f"{self.date} {support}",
                dt_s=self.dt_s,
                accel_1_mps2=along,
                accel_2_mps2=across,
                event=self.date,
                station=station.title,
            )
        return found


def read_events(folder: Path, station: Station) -> list[Event]:
    """Return the events in a folder: of its own files, or one per subfolder with files.

    Raises `InputError` for a folder without files, another station or missing channels.
    """
    folders = [folder, *(path for path in folder.glob("*") if path.is_dir())]
    files = {each: sorted(each.glob("*.[vV]2")) for each in folders}
    events = [_event(each, paths, station) for each, paths in files.items() if paths]
    if not events:
        raise InputError(f"{folder}: no .V2 file of an event, here or in its folders")
    return sorted(events, key=lambda event: event.date)


def _event(folder: Path, paths: list[Path], station: Station) -> Event:
    found: dict[int, Series] = {}
    steps_s: set[float] = set()
    date = folder.name
    for path in paths:
        text = read_text(path, MAX_V2_BYTES)
        headers = [text[title.start() :][:2500] for title in _TITLE.finditer(text)]
        for number, header in enumerate(headers, start=1):
            own = _STATION.search(header)
            channel = _CHANNEL.search(header) or _RECORDER_CHANNEL.search(header)
            if own is None or own[1].lstrip("0") != station.station:
                given = f"station {own[1]}" if own else "no station number"
                raise InputError(
                    f"{path}: {given} in its header, but {station.title} is station "
                    f"{station.station}"
                )
            if channel is None or int(channel[1]) in found:
                continue
            trace = read_trace(path, Stated(channel=number))
            found[int(channel[1])] = trace.accel_mps2
            steps_s.add(trace.dt_s)
            date = _date(header) or date
    if missing := sorted(station.required - found.keys()):
        raise InputError(
            f"{folder}: channel {', '.join(map(str, missing))} of station {station.station} is "
            f"missing; the comparison needs {', '.join(map(str, sorted(station.required)))}"
        )
    if len(steps_s) > 1:
        raise InputError(f"{folder}: time steps of {sorted(steps_s)} s; one event has one step")
    notes: list[str] = []
    for each in station.grounds:
        if each.channel not in found and each.instead is not None:
            found[each.channel] = found[each.instead]
            notes.append(f"channel {each.instead} replaces channel {each.channel}")
    absent = [each for each in station.quantities if each.channel not in found]
    notes += [f"channel {each.channel} is missing: no {each.name}" for each in absent]
    # ASSUME recorders of one event start together; those of Painter Street do, within 6 ms
    count = min(values.size for values in found.values())
    cut = {channel: values[:count] for channel, values in sorted(found.items())}
    return Event(date=date, dt_s=steps_s.pop(), accel_mps2=cut, notes=tuple(notes))


def _date(header: str) -> str:
    for month, day, year in _DATE.findall(header):
        if month.capitalize() in _MONTHS:
            return f"{year}-{_MONTHS.index(month.capitalize()):02d}-{int(day):02d}"
    return ""


def strong_part(accel: Series, dt_s: float) -> slice:
    """Return the samples of the strong part of a recording, with a second before and two after."""
    share = np.cumsum(accel**2) / np.sum(accel**2)
    first, last = np.searchsorted(share, _STRONG)
    start = max(0, int(first - _LEAD_S / dt_s))
    return slice(start, min(len(accel), int(last + _TAIL_S / dt_s)))


def in_band(values: Series, dt_s: float, derivative: int = 0) -> Series:
    """Return a history in the band, differentiated (or, if negative, integrated) so many times.

    It is filtered without phase shift; ramps of the filter are cosines of the logarithm.
    """
    count = len(values)
    line = np.polynomial.Polynomial.fit(np.arange(count), values, 1)(np.arange(count))
    spectrum = np.fft.rfft(values - line, 2 * count)
    frequency = np.fft.rfftfreq(2 * count, dt_s)
    frequency[0] = 1.0e-9
    low, high = BAND_HZ
    rise = np.log(frequency / (low * _RAMP[0])) / np.log(1.0 / _RAMP[0])
    fall = np.log(high * _RAMP[1] / frequency) / np.log(_RAMP[1])
    gain = np.prod([(1 - np.cos(np.pi * np.clip(ramp, 0, 1))) / 2 for ramp in (rise, fall)], axis=0)
    spectrum *= gain * (2j * np.pi * frequency) ** derivative
    return np.fft.irfft(spectrum, 2 * count)[:count]


@dataclass(frozen=True, slots=True, kw_only=True)
class Period:
    """Identified period and damping ratio; `half_range_s` is the scatter of both halves."""

    period_s: float
    damping: float
    half_range_s: float
    explained: float


def identified_period(output: Series, inputs: Series, dt_s: float) -> Period:
    """Return the period of one mode that explains an absolute acceleration from those of supports.

    Output error of one mode with several inputs: the output is a sum of inputs and of responses of
    an oscillator to them. Only the period and damping of the oscillator are searched, the shares
    follow by least squares.

    Args:
        output: Acceleration, shape (n,), in the band.
        inputs: Accelerations, shape (n, supports), in the band.
        dt_s: Time step.
    """
    whole = _fitted_mode(output, inputs, dt_s)
    middle = len(output) // 2
    halves = [
        _fitted_mode(output[part], inputs[part], dt_s)
        for part in (slice(middle), slice(middle, None))
    ]
    spread = max(abs(half.period_s - whole.period_s) for half in halves)
    return replace(whole, half_range_s=spread)


def _fitted_mode(output: Series, inputs: Series, dt_s: float) -> Period:
    from scipy.optimize import minimize

    count = len(output)
    spectra = np.fft.rfft(inputs, 2 * count, axis=0)
    speed = 2 * np.pi * np.fft.rfftfreq(2 * count, dt_s)

    def left(values: Series) -> float:
        """Return the share of the output that an oscillator does not explain."""
        period_s, damping = np.exp(values)
        own = 2 * np.pi / period_s
        gain = speed**2 / (own**2 - speed**2 + 2j * damping * own * speed)
        moved = np.fft.irfft(spectra * gain[:, None], 2 * count, axis=0)[:count]
        columns = np.hstack([inputs, moved])
        found = columns @ np.linalg.lstsq(columns, output, rcond=None)[0]
        return float(np.sum((output - found) ** 2) / np.sum(output**2))

    starts = [np.log([period_s, 0.1]) for period_s in (0.18, 0.25, 0.32, 0.45)]
    limits = [tuple(np.log([0.1, 0.8])), tuple(np.log([0.01, 0.5]))]
    best = min(
        (minimize(left, start, method="Nelder-Mead", bounds=limits) for start in starts),
        key=lambda found: found.fun,
    )
    period_s, damping = np.exp(best.x)
    return Period(
        period_s=float(period_s),
        damping=float(damping),
        half_range_s=0.0,
        explained=1.0 - float(best.fun),
    )
