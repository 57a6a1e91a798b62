"""Six numbers of the Painter Street overcrossing, fitted to two small earthquakes.

`python benchmarks/painter_fit.py DIR [ONE]` reads the recordings below DIR and writes
`docs/data/recorded_fit.csv`: the numbers fitted to both events, and to each one alone, with the
agreement in both events. With ONE (both, 2015-01-28 or 2019-06-22), only that fit is made. The
numbers of the bridge file are those fitted to both, rounded to two digits; no other event is read.
"""

import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from skewbridge.files.tables import Floats as Series
from skewbridge.verification.studies.recorded import (
    Recording,
    comparison,
    predicted,
    read_events,
    read_station,
    recording_of,
)

OUT: Final = Path(__file__).parents[1] / "docs" / "data" / "recorded_fit.csv"
STATION: Final = read_station("painter")
#: Start and limits of each number.
NUMBERS: Final = {
    "fill_mn_per_m2": (20.0, 1.0, 500.0),
    "piles_west_kn_per_m": (1.5e5, 1e4, 1e6),
    "piles_east_kn_per_m": (1.5e5, 1e4, 1e6),
    "piles_dashpot_s": (0.02, 1e-3, 0.2),
    "rocking_mnm_per_rad": (9.0e3, 1e3, 6e4),
    "deck_modulus_gpa": (45.0, 15.0, 80.0),
}
FILE: Final = """extends: painter
source: "b: fitted"
deck: {{elastic_modulus_gpa: {deck_modulus_gpa}}}
foundation: {{krx_mnm_per_rad: {rocking_mnm_per_rad}, kry_mnm_per_rad: {rocking_mnm_per_rad}}}
abutments:
  left:
    backfill: {{stiffness_mn_per_m: {fill_mn_per_m2}}}
    piles: {{lateral_kn_per_m: {piles_west_kn_per_m}, dashpot_s: {piles_dashpot_s}}}
  right:
    backfill: {{stiffness_mn_per_m: {fill_mn_per_m2}}}
    piles: {{lateral_kn_per_m: {piles_east_kn_per_m}, dashpot_s: {piles_dashpot_s}}}
"""


def histories(
    values: Sequence[float], recordings: Mapping[str, Recording], name: str
) -> dict[str, dict[str, Series]]:
    """Return the quantities of a bridge with these numbers in each event."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.yaml"
        path.write_text(FILE.format(**dict(zip(NUMBERS, map(float, values), strict=True))))
        case = STATION.changed({"bridge": str(path)})
        return {date: predicted(each, case, dt_s=0.01) for date, each in recordings.items()}


def fitted(recordings: Mapping[str, Recording], name: str) -> tuple[Series, Series]:
    """Return the numbers fitted to events, and the standard deviations of their logarithms."""
    start, low, high = np.log(np.array(list(NUMBERS.values()))).T
    compared = [each.name for each in STATION.quantities if each.peak]

    def residuals(logarithms: Series) -> Series:
        try:
            found = histories(np.exp(logarithms), recordings, name)
        except RuntimeError:  # no equilibrium: as bad as no motion at all
            return np.concatenate(
                [each.recorded[q] * 2 for each in recordings.values() for q in compared]
            )
        return np.concatenate(
            [
                (found[date][q] - each.recorded[q]) / np.linalg.norm(each.recorded[q])
                for date, each in recordings.items()
                for q in compared
            ]
        )

    best = least_squares(residuals, start, bounds=(low, high), diff_step=0.02, max_nfev=10)
    # ASSUME a hundred independent values: samples in the band are strongly correlated
    spread = np.linalg.pinv(best.jac.T @ best.jac) * 2.0 * best.cost / 100.0
    return np.exp(best.x), np.sqrt(np.diag(spread))


def main(folder: Path, only: str | None) -> None:
    """Make the fits and write the table."""
    events = [e for e in read_events(folder, STATION) if e.date in STATION.fitted]
    recordings = {event.date: recording_of(event, STATION) for event in events}
    fits = {"both": recordings} | {date: {date: each} for date, each in recordings.items()}
    rows: list[dict[str, object]] = []
    for name, some in fits.items():
        if only not in (None, name):
            continue
        values, spread = fitted(some, name.replace("-", "_"))
        found = histories(values, recordings, "check")
        for date, each in recordings.items():
            for quantity, recorded in each.recorded.items():
                agreement = comparison(found[date][quantity], recorded)
                rows.append(
                    {"fitted_to": name, "event": date, "quantity": quantity}
                    | {key: round(value, 3) for key, value in agreement.items()}
                    | {key: f"{value:.3g}" for key, value in zip(NUMBERS, values, strict=True)}
                    | {
                        f"sd_ln_{key}": f"{value:.2g}"
                        for key, value in zip(NUMBERS, spread, strict=True)
                    }
                )
    with (OUT if only is None else OUT.with_stem(f"recorded_fit_{only}")).open(
        "w", newline=""
    ) as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *(sys.argv[2:] or [None]))
