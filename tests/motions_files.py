"""Small motion folders for the tests of the motions package."""

from pathlib import Path

import numpy as np
import pandas as pd

HEADER = """PEER NGA STRONG MOTION DATABASE RECORD
Quake, 1/17/1994, Station, {azimuth}
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= {npts:6d}, DT= {dt:.4f} SEC
"""
COSMOS_CODES = {"acceleration": (1, 4, "cm/sec2(04)"), "velocity": (2, 5, "cm/sec(05)"),
                "displacement": (3, 6, "cm(06)")}  # fmt: skip


def at2_text(values_g: np.ndarray, dt_s: float = 0.01, azimuth: int = 90) -> str:
    header = HEADER.format(npts=len(values_g), dt=dt_s, azimuth=azimuth)
    return header + rows_of(values_g, 5, "{:15.7E}") + "\n"


def shaken_g(seed: int, npts: int = 400) -> np.ndarray:
    rng = np.random.default_rng(seed)
    accel = np.diff(np.cumsum(rng.standard_normal(npts)) * np.hanning(npts) ** 2, prepend=0.0)
    return 0.3 * accel / np.abs(accel).max()


def make_pairs(folder: Path, count: int) -> list[tuple[Path, Path]]:
    pairs = []
    for i in range(count):
        files = (folder / f"q{i}_h1.AT2", folder / f"q{i}_h2.AT2")
        for component, path in enumerate(files):
            path.write_text(at2_text(shaken_g(10 * i + component)))
        pairs.append(files)
    return pairs


def index_of(folder: Path, pairs: list[tuple[Path, Path]], **columns: list) -> Path:
    given = {"motion_id": [first.stem.removesuffix("_h1") for first, _ in pairs],
             "file_1": [first.name for first, _ in pairs],
             "file_2": [second.name for _, second in pairs]}  # fmt: skip
    pd.DataFrame(given | columns).to_csv(folder / "index.csv", index=False)
    return folder / "index.csv"


def rows_of(values: np.ndarray, per_line: int, form: str) -> str:
    lines = (values[i : i + per_line] for i in range(0, len(values), per_line))
    return "\n".join("".join(map(form.format, line)) for line in lines)


def esm_text(values: np.ndarray, dt_s: float = 0.005, stream: str = "HNE", **changes: str) -> str:
    """Return the text of an ESM file (DYNA 1.2): 64 header lines, values in cm/s2."""
    head = {
        "EVENT_NAME": "TESTQUAKE", "EVENT_ID": "EMSC-1", "NETWORK": "XX", "STATION_CODE": "ABC",
        "VS30_M/S": "760", "EPICENTRAL_DISTANCE_KM": "12.0", "SAMPLING_INTERVAL_S": f"{dt_s:.6f}",
        "NDATA": str(len(values)), "STREAM": stream, "UNITS": "cm/s^2",
        "PGA_CM/S^2": f"{np.abs(values).max():.6f}", "HEADER_FORMAT": "DYNA 1.2",
        "DATA_TYPE": "ACCELERATION",
    }  # fmt: skip
    head |= changes
    lines = [f"{key}: {text}" for key, text in head.items()]
    lines += [f"USER{n}: " for n in range(1, 65 - len(lines))]
    return "\n".join(lines) + "\n" + rows_of(values, 1, "{:.6f}") + "\n"


def cosmos_text(
    values: np.ndarray,
    dt_s: float = 0.005,
    azimuth: int = 90,
    scnl: str = "ABC.HNE.XX.--",
    quantity: str = "acceleration",
    layout: tuple[str, int, str] = ("(1E15.6)", 1, "{:15.6e}"),
    unit: tuple[int, int, str] | None = None,
) -> str:
    """Return the text of one channel and quantity of a COSMOS file, values in cm and s."""
    parameter, code, name = unit or COSMOS_CODES[quantity]
    integers, reals = np.full(100, -999), np.full(100, -999.0)
    integers[[0, 1, 2, 3, 53]] = (2, parameter, code, 120, azimuth)
    # the step of the record before processing is another one
    reals[[33, 61, 62]] = (0.02, 1000.0 * dt_s, dt_s * len(values))
    text = [
        f"Corrected {quantity}    (Format v01.20 with 13 text lines)", "Record of Test Quake",
        "Hypocenter: 1.0 2.0 H= 46km Mw=7.0", "Origin: 2018/11/30", "Statn No: 37-11 Code:XX-ABC",
        "Coords: 60.9 -144.6", "Recorder:", "Rcrd start time:", "Sta Chan   ?:Other", "Raw record",
        "Processed: Max = -6.852 cm/sec2 at 76.215 sec", "Record filtered below 0.03 Hz",
        "Values used when parameter or data value is unknown/unspecified:   -999, -999.00",
        " 100 Integer-header values follow on  10 lines, Format= (10I8)",
        rows_of(integers, 10, "{:8d}"),
        " 100 Real-header values follow on  20 lines, Format= (5F15.6)",
        rows_of(reals, 5, "{:15.6f}"),
        '   1 Comment line(s) follow, each starting with a "|":', f"|<SCNL>{scnl}    <AUTH> 2019",
    ]  # fmt: skip
    form, per_line, number = layout
    count, length = len(values), round(dt_s * len(values))
    text.append(f"{count:8d} {quantity} pts, approx {length:4d} secs, units={name},Format={form}")
    return "\n".join([*text, rows_of(values, per_line, number), f"End-of-data for {quantity}", ""])


def geonet_text(components: dict[str, np.ndarray], dt_s: float = 0.02) -> str:
    """Return the text of a GeoNet file with velocities and displacements; values in mm/s2."""
    text: list[str] = []
    for name, values in components.items():
        integers, reals = np.zeros(40, dtype=int), np.zeros(60)
        integers[33:36] = len(values), len(values), 7
        reals[[24, 25, 29]] = 0.005, dt_s, 9806.6
        text += [
            "Corrected accelerogram 20161113_TEST_20 GNS Science", "Site ABC      42 37 10S",
            "Test Farm", "Instrument Cusp_1", "Resolution: 18-bit", "Accelerogram 20161113",
            "5 km south", "2016 November 13         11:02:56 UT", "Epicentre  42 41 33S",
            f"Number of points {len(values):5d}    Duration", "Instrument corrected data",
            "Band-pass filter", f"Component {name}  Accelerometer Axis",
            "Acceleration:  peak  1.0 mm/s/s", "Velocity:      peak 1.0 mm/s",
            "Displacement:  peak  1.0 mm", rows_of(integers, 10, "{:8d}"),
            rows_of(reals, 10, "{:8.4g}"), rows_of(values, 10, "{:8.1f}"),
            rows_of(np.full(len(values), 333.0), 10, "{:8.1f}"),
            rows_of(np.full(7, 444.0), 10, "{:8.1f}"),
        ]  # fmt: skip
    return "\n".join(text) + "\n"


def v2_text(cm_s2, form="{:10.3f}", line="AT  .010 SEC.  (UNITS: CM/SEC/SEC)", channel="1: 270"):
    head = ["CORRECTED ACCELEROGRAM   TEST", "UNCORRECTED DATA", "TEST QUAKE", *["x"] * 3,
            "TEST STATION", f"CHAN  {channel}", *["x"] * 17, *["    0    1"] * 20]  # fmt: skip
    head.append(f"{len(cm_s2):5d} POINTS OF ACCEL DATA EQUALLY SPACED {line}")
    return "\n".join([*head, rows_of(cm_s2, 8, form), "    1 POINTS OF VELOC DATA", "     1.000"])


def knet_text(counts) -> str:
    peak_gal = np.abs(counts - counts.mean()).max() * 2000 / 8388608
    head = [
        "Origin Time       2000/01/01 00:00:00", "Station Code      ABC001", *["Lat.   1"] * 8,
        "Sampling Freq(Hz) 100Hz", "Duration Time(s)  1", "Dir.              4",
        "Scale Factor      2000(gal)/8388608", f"Max. Acc. (gal)   {peak_gal:.3f}",
        "Last Correction   2000/01/01 00:00:00", "Memo.             ",
    ]  # fmt: skip
    return "\n".join([*head, rows_of(counts, 8, "{:9d}")])
