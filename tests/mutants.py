"""Mutated input files: made from good ones with a fixed seed, read in a child under limits.

`python tests/mutants.py COUNT SEED FOLDER FAMILY...` reads COUNT mutants of each family and prints
one JSON object: numbers of accepted and refused mutants, the largest processor time, and every
mutant that ended with anything but one message. A mutant that reaches a limit ends the process; its
file is left in the folder.
"""

import json
import random
import resource
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from motions_files import at2_text
from mutation import mutant_of
from skewbridge.bridge.catalogue import load_bridge_file
from skewbridge.errors import InputError
from skewbridge.files.tables import write_frame
from skewbridge.fragility.fit_data import FitOptions, fit_file
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.folder import list_motions
from skewbridge.motions.formats import Given
from skewbridge.motions.read import DT_LIMITS_S, PGA_LIMITS_G, read_trace
from skewbridge.motions.suite import read_entry
from skewbridge.study.config import load_config
from skewbridge.units import G_MPS2
from skewbridge.variant.grid import expand_grid
from skewbridge.verification.references.cases import (
    ContactCase,
    DeckCase,
    read_case,
    read_path,
)

ROOT = Path(__file__).parents[1]
CPU_LIMIT_S = 5
MEMORY_LIMIT = 500_000_000
LONGEST_MESSAGE = 8000

# Valid files and their readers.


def wave(count: int = 60) -> np.ndarray:
    return 0.2 * np.sin(np.arange(count) / 5.0) * np.exp(-np.arange(count) / 40.0)


def knet_text() -> str:
    head = [
        "Origin Time       2011/03/11 14:46:00", "Lat.              38.1",
        "Long.             142.8",
        "Depth. (km)       24", "Mag.              9.0", "Station Code      MYG004",
        "Station Lat.      38.7", "Station Long.     141.0", "Station Height(m) 40",
        "Record Time       2011/03/11 14:46:15", "Sampling Freq(Hz) 100Hz", "Duration Time(s)  1",
        "Dir.              N-S", "Scale Factor      7845(gal)/8223790", "Max. Acc. (gal)   196.0",
        "Last Correction   2011/03/11 14:46:00", "Memo.",
    ]  # fmt: skip
    return "\n".join([*head, *(f"{int(value * 1e6):9d}" for value in wave())]) + "\n"


def v2_text() -> str:
    values = [f"{980.665 * value:10.3f}" for value in wave(64)]
    rows = ["".join(values[i : i + 8]) for i in range(0, 64, 8)]
    head = "64 points of accel data equally spaced at  .020 sec, in cm/sec2. (8f10.3)"
    return "\n".join(["CORRECTED ACCELEROGRAM", *["header"] * 44, head, *rows]) + "\n"


def columns_text(separator: str, count: int) -> str:
    rows = (
        separator.join([f"{0.01 * number:.2f}", *[f"{value:.6f}"] * count])
        for number, value in enumerate(wave())
    )
    return "\n".join([",".join(["time_s", *["accel_g"] * count]), *rows]) + "\n"


def read_record(path: Path, given: Given | None = None) -> None:
    """Read a component; what passes must be a possible record."""
    trace = read_trace(path, given)
    assert np.isfinite(trace.accel_mps2).all()
    assert DT_LIMITS_S[0] <= trace.dt_s <= DT_LIMITS_S[1]
    assert 0.0 < np.abs(trace.accel_mps2).max() <= PGA_LIMITS_G[1] * G_MPS2
    assert trace.unit in {"g", "cm/s2", "m/s2"}


INDEX = (
    "motion_id,file_1,file_2,event,magnitude,unit,dt_s,scale\n"
    "one,one_h1.AT2,one_h2.AT2,Event,7.1,g,0.01,1.5\ntwo,one_h1.AT2,one_h2.AT2,,,,,\n"
)
CONTACT = {
    "normal_stiffness_n_per_m": 1.0e5, "tangent_stiffness_n_per_m": 1.0e5, "friction": 0.3,
    "cohesion_n": 1500.0, "gap_m": 0.0, "scheme": "vector", "coupling": "extrapolated",
    "substeps": 10, "path": "path.csv",
}  # fmt: skip
DECK = {
    "length_m": 30.0, "width_m": 15.0, "skew_deg": 30.0, "mass_kg": 1000.0, "period_x_s": 0.5,
    "period_y_s": 0.5, "period_theta_s": 0.3, "damping_ratio": 0.05, "gap_normal_m": 0.003,
    "friction": 0.0, "normal_stiffness_n_per_m": 1.0e7, "solver": "opensees", "dt_s": 1.0e-3,
    "duration_s": 0.1, "pulse": {"kind": "cosine", "amplitude_g": 0.5, "period_s": 0.5},
}  # fmt: skip
PATH = "t_s,ux_m,uy_m,uz_m\n0.0,0.0,0.0,-0.01\n0.1,0.02,0.01,-0.01\n0.2,0.0,0.02,0.01\n"
CSV = "im,edp,threshold\n0.1,0.01,0.03\n0.2,0.02,0.03\n0.4,0.05,0.03\n"
CLOUD = {"im": [0.1, 0.2, 0.4, 0.8], "edp": [0.01, 0.02, 0.03, 0.09], "threshold": 0.03}
STRIPES = {"im": [0.2, 0.4, 0.6, 0.8], "n": [20] * 4, "k": [0, 4, 12, 18]}


def text_of(name: str) -> bytes:
    return (ROOT / name).read_bytes()


def as_yaml(value: object) -> bytes:
    return yaml.safe_dump(value, sort_keys=False).encode()


def read_index(path: Path) -> None:
    for number in (1, 2):
        (path.parent / f"one_h{number}.AT2").write_text(at2_text(wave()), encoding="utf-8")
    path.replace(path.parent / "index.csv")
    for entry in list_motions(path.parent):
        read_entry(entry)


def read_bridge(path: Path) -> None:
    load_bridge_file(path)


def read_study(path: Path) -> None:
    expand_grid(load_config(path, base=ROOT / "config/config.yaml").grid)


def fit(method: str, **options: object) -> Callable[[Path], object]:
    return lambda path: fit_file(path, FitOptions(method=method, **options)).as_json()


def parquet_bytes(folder: Path) -> bytes:
    path = folder / "good.parquet"
    table = pd.DataFrame({**CLOUD, "motion_id": ["a", "b", "c", "d"], "status": ["ok"] * 4})
    write_frame(table, path, {"made_by": "tests"})
    return path.read_bytes()


RUNS = {"im": "im", "edp": "edp", "threshold": 0.03}
FAMILIES: dict[str, tuple[str, list[bytes], Callable[[Path], object]]] = {
    "at2": (".AT2", [at2_text(wave()).encode()], read_record),
    "v2": (".V2", [v2_text().encode()], read_record),
    "knet": (".NS", [knet_text().encode()], read_record),
    "columns": (".csv", [columns_text(",", 1).encode()], read_record),
    "three_columns": (
        ".txt", [columns_text(" ", 2).encode()], lambda path: read_record(path, Given(channel=2))
    ),
    "values": (
        ".acc", [b"\n".join(b"%.6e" % value for value in wave())],
        lambda path: read_record(path, Given(dt_s=0.01)),
    ),
    "index": (".txt", [INDEX.encode()], read_index),
    "config": (".yaml", [text_of(f"config/{n}.yaml") for n in ("config", "ida")], read_study),
    "limit_states": (".yaml", [text_of("config/limit_states.yaml")], load_limit_states),
    "bridge": (
        ".yaml",
        [text_of("config/bridges/template.yaml"),
         b"extends: osb1\ndeck:\n  depth_m: {v: 2, src: 'd: x'}\n"],
        read_bridge,
    ),
    "fit_cloud": (".json", [json.dumps(CLOUD).encode()], fit("cloud")),
    "fit_stripes": (".json", [json.dumps(STRIPES).encode()], fit("stripes")),
    "fit_csv": (".csv", [CSV.encode()], fit("cloud")),
    "fit_parquet": (".parquet", [], fit("cloud", **RUNS)),
    "contact": (".yaml", [as_yaml(CONTACT)], lambda path: read_case(path, ContactCase)),
    "deck": (".yaml", [as_yaml(DECK)], lambda path: read_case(path, DeckCase)),
    "path": (".csv", [PATH.encode()], read_path),
}  # fmt: skip
# Messages about data name the column and the row; the file is the one on the command line.
NAMELESS = {"fit_cloud", "fit_stripes", "fit_csv", "fit_parquet", "index"}


def run_family(name: str, count: int, seed: int, folder: Path) -> dict[str, object]:
    """Read mutants of one family; return the counts and faults."""
    suffix, seeds, read = FAMILIES[name]
    seeds = seeds or [parquet_bytes(folder)]
    chance = random.Random(f"{seed} {name}")
    taken, refused, dearest_s, faults = 0, 0, 0.0, []
    for content in seeds:
        good = folder / f"good{suffix}"
        good.write_bytes(content)
        read(good)
    for number in range(count):
        path = folder / f"{name}{number}{suffix}"
        path.write_bytes(mutant_of(chance.choice(seeds), suffix, chance))
        began_s = time.process_time()
        resource.setrlimit(resource.RLIMIT_CPU, (int(began_s) + CPU_LIMIT_S + 1, -1))
        try:
            read(path)
        except InputError as error:
            refused += 1
            faults += [[path.name, text] for text in complaints(str(error), path, name)]
        except Exception:
            faults.append([path.name, traceback.format_exc()[-1500:]])
        else:
            taken += 1
        dearest_s = max(dearest_s, time.process_time() - began_s)
        if not faults or faults[-1][0] != path.name:
            path.unlink(missing_ok=True)
    return {"taken": taken, "refused": refused, "dearest_s": dearest_s, "faults": faults}


def complaints(message: str, path: Path, family: str) -> list[str]:
    """Return the faults of a message."""
    found = []
    if len(message) > LONGEST_MESSAGE or not message:
        found.append(f"a message of {len(message)} characters: {message[:300]}")
    if not all(sign.isprintable() or sign == "\n" for sign in message):
        found.append(f"control characters in {message[:300]!r}")
    if family not in NAMELESS and path.name not in message:
        found.append(f"does not name the file: {message[:300]}")
    return found


def main(count: int, seed: int, folder: Path, names: list[str]) -> None:
    loaded = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (loaded + MEMORY_LIMIT, -1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000_000, -1))
    found = {}
    for name in names:
        own = folder / name
        own.mkdir()
        found[name] = run_family(name, count, seed, own)
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
