"""Mutated input files: made from good ones with a fixed seed, read in a child under limits.

`read_mutants` counts accepted and refused mutants and lists every one that ended with anything but
one message. A mutant that reaches a limit ends the process; its file is left in the folder."""

import copy
import json
import random
import resource
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

import motions_files as made
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.files.tables import write_frame
from skewbridge.fragility.fit_data import fit_file
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.folder import list_motions
from skewbridge.motions.formats import DT_LIMITS_S, UNIT_FACTORS, Stated
from skewbridge.motions.read import PGA_LIMITS_G, read_trace
from skewbridge.motions.suite import read_entry
from skewbridge.study.config import load_config
from skewbridge.units import G_MPS2
from skewbridge.variant.grid import expand_grid
from skewbridge.verification.references.cases import ContactCase, DeckCase, read_case, read_path

ROOT = Path(__file__).parents[1]
CPU_LIMIT_S = 5
MEMORY_LIMIT = 500_000_000
LONGEST_MESSAGE = 8000


def wave(count=60):
    return 0.2 * np.sin(np.arange(count) / 5.0) * np.exp(-np.arange(count) / 40.0)


def columns_text(separator, count):
    columns = [0.01 * np.arange(60), *[wave()] * count]
    names = ",".join(["time_s", *["accel_g"] * count])
    rows = (separator.join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join([names, *rows]) + "\n"


def read_record(path, given=None):
    """Read a component; what passes must be a possible record."""
    trace = read_trace(path, given)
    assert np.isfinite(trace.accel_mps2).all()
    assert DT_LIMITS_S[0] <= trace.dt_s <= DT_LIMITS_S[1]
    assert 0.0 < np.abs(trace.accel_mps2).max() <= PGA_LIMITS_G[1] * G_MPS2
    assert trace.unit in UNIT_FACTORS


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


def shipped(name):
    return (ROOT / f"config/{name}.yaml").read_bytes()


def as_yaml(value):
    return yaml.safe_dump(value, sort_keys=False).encode()


def read_index(path):
    for number in (1, 2):
        (path.parent / f"one_h{number}.AT2").write_text(made.at2_text(wave()), encoding="utf-8")
    path.replace(path.parent / "index.csv")
    for entry in list_motions(path.parent):
        read_entry(entry)


def fit(method, **options):
    return lambda path: fit_file(path, method=method, **options).as_json()


FAMILIES: dict[str, tuple[str, list[bytes], Callable[[Path], object]]] = {
    "at2": (".AT2", [made.at2_text(wave()).encode()], read_record),
    "v2": (".V2", [made.v2_text(980.665 * wave()).encode()], read_record),
    "knet": (".NS", [made.knet_text((1e6 * wave()).astype(int)).encode()], read_record),
    "esm": (".ASC", [made.esm_text(980.665 * wave()).encode()], read_record),
    "cosmos": (".V2c", [made.cosmos_text(980.665 * wave()).encode()], read_record),
    "geonet": (".V2A", [made.geonet_text({"N28W": 9806.65 * wave()}).encode()], read_record),
    "columns": (".csv", [columns_text(",", 1).encode()], read_record),
    "three_columns": (
        ".txt", [columns_text(" ", 2).encode()], lambda path: read_record(path, Stated(channel=2))
    ),
    "values": (
        ".acc", [b"\n".join(b"%.6e" % value for value in wave())],
        lambda path: read_record(path, Stated(dt_s=0.01)),
    ),
    "index": (".txt", [INDEX.encode()], read_index),
    "config": (
        ".yaml", [shipped(n) for n in ("config", "ida")],
        lambda path: expand_grid(load_config(path, base=ROOT / "config/config.yaml").grid),
    ),
    "limit_states": (".yaml", [shipped("limit_states")], load_limit_states),
    "bridge": (
        ".yaml",
        [shipped("bridges/template"),
         b"extends: osb1\ndeck:\n  depth_m: {v: 2, src: 'd: x'}\n"],
        load_bridge,
    ),
    "fit_cloud": (".json", [json.dumps(CLOUD).encode()], fit("cloud")),
    "fit_stripes": (".json", [json.dumps(STRIPES).encode()], fit("stripes")),
    "fit_csv": (".csv", [CSV.encode()], fit("cloud")),
    "fit_parquet": (".parquet", [], fit("cloud", im="im", edp="edp", threshold=0.03)),
    "contact": (".yaml", [as_yaml(CONTACT)], lambda path: read_case(path, ContactCase)),
    "deck": (".yaml", [as_yaml(DECK)], lambda path: read_case(path, DeckCase)),
    "path": (".csv", [PATH.encode()], read_path),
}  # fmt: skip
# Messages about data name the column and the row; the file is the one on the command line.
NAMELESS = {"fit_cloud", "fit_stripes", "fit_csv", "fit_parquet", "index"}


# Replacements of a value of a document, as text.
SNIPPETS = (
    "1e300", "-1.0e+300", "1.0e-300", "0", "-1", "-0.0", ".nan", ".inf", "1e5000", "9" * 5000,
    "0x" + "f" * 3000, "1:" * 900 + "1", "true", "null", "''", "[]", "{}", "[/red]", "'\\0'",
    "../../etc/passwd", '"\\x1b[31m"', "'=1+1'", "<script>alert(1)</script>", "$\\frac$",
    "x" * 5000, "'" + "/x" * 60_000 + "'", "[" * 2000, "[" * 40 + "]" * 40,
    "{a: " * 40 + "1" + "}" * 40, "&a [*a]", "*nothing", "!!python/name:os.system", "!!binary x",
    "!!timestamp 2020-13-45", "!!int x", "? [a]", "<<: 1", "2e7", "é", "[1, 2, 3]",
    "{v: 1.0e+9, src: 'd: x'}", "{v: -5, src: 'd: x'}", "{v: [1, 2], src: 'd: x'}", "1.0e+3",
    "1.0e-6", "1000000", "17",
)  # fmt: skip


def nested(first, form):
    """Return a document in which each value repeats the one before nine times."""
    pairs = zip("abcdefgh", "bcdefghi", strict=True)
    return first + "".join(f"{new}: &{new} {form.format(', '.join([f'*{old}'] * 9))}\n"
                           for old, new in pairs)  # fmt: skip


BOMB = nested("a: &a [x, x, x, x, x, x, x, x, x]\n", "[{}]")
MERGES = nested("a: &a {x: 1}\n", "{{<<: [{}]}}")
WHOLE = (
    b"", b"\n", b"\xff\xfe\x00", b"\x00" * 100, b"\xef\xbb\xbf", b"---\n---\n", b"- " * 5000 + b"x",
    b"[" * 100_000, b'{"a":' * 100_000, b"{" * 5000, BOMB.encode(), MERGES.encode(),
    b"a: 1\na: 2\n",
    b"x" * 300_000, b"\x1b[31m", b"%YAML 9.9\n---\na: 1\n", b"extends: osb1\nextends: osb1\n",
    b"? " * 3000, b"- - " * 3000, b"'", b"#" * 10_000, b"a,b\n1,2\n" * 3,
)  # fmt: skip
BYTES = (
    b"\xff", b"\x00", b"\x1b[31m", b"\xc3", b"9" * 5000, b"[/red]", b"nan", b"inf", b"1e400", b",",
    b"\n", b"\t", b";", b'"', b"'", b":", b"-", b"*", b"&", b"{", b"[", b"\xe2\x80\xa8", b"=1+1",
    b"1e-320", b"D+99", b"0", b" ", b"-Infinity", b"*******", b"1D5", b"1,5", b"--", b"..", b"E",
    b"0x10", b"1_000", b"\xd9\xa3", b"\xef\xbb\xbf", b"1" * 5000 + b"x", b" " * 999, b"\n" * 50,
    b"NPTS= 99999999999999999999, DT= 1e-300 SEC", b"DT= 0.0", b"DT= -1", b"UNITS OF CM/SEC2",
    b"VELOCITY", b"points of accel data equally spaced at 0 sec", b"Scale Factor 0(gal)/0",
    b"Sampling Freq(Hz) 1e400Hz", b"<html>", b"PK\x03\x04", b"-1e308", b"\r",
)  # fmt: skip


def of_bytes(content, chance):
    for _ in range(chance.randint(1, 4)):
        start = chance.randrange(len(content) + 1)
        end = start + chance.choice((0, 1, 1, 2, 8, 60, 500))
        old, token = content[start:end], chance.choice(BYTES)
        flipped = bytes(byte ^ 1 << chance.randrange(8) for byte in old[:1]) + old[1:]
        kinds = (flipped, token, token + old, b"", old * chance.choice((2, 3, 31)), "cut", "swap")
        match chance.choice(kinds):
            case "cut":
                content = content[:start]
            case "swap":
                lines = content.split(b"\n")
                one, other = chance.choices(range(len(lines)), k=2)
                lines[one], lines[other] = lines[other], lines[one]
                content = b"\n".join(lines)
            case new:
                content = content[:start] + new + content[end:]
    return content


def of_structure(content, chance):
    """Return a document with one to three of its values changed, dropped or doubled. It is written
    as JSON, which is YAML as well."""
    tree = yaml.safe_load(content)
    for number in range(chance.randint(1, 3)):
        holders = [node for node in nodes_of(tree) if node]
        if not holders:
            break
        node = chance.choice(holders)
        key = chance.choice(list(node) if isinstance(node, dict) else range(len(node)))
        kind = chance.randrange(8)
        if kind == 0:
            del node[key]
        elif kind == 1 and isinstance(node, dict):
            node[chance.choice(("", "v", "x" * 300, "[/red]", "1", "colour"))] = node[key]
        elif kind == 2:
            node[key] = copy.deepcopy(chance.choice(holders))
        elif kind == 3 and isinstance(node[key], int | float):
            node[key] *= chance.choice((-1, 0, 1e-6, 0.1, 3, 10, 1e3, 1e6, 1e300))
        else:
            node[key] = f"@@{number}@@"
    text = json.dumps(tree, default=str)
    for number in range(3):
        text = text.replace(f'"@@{number}@@"', chance.choice(SNIPPETS))
    return text.encode()


def nodes_of(tree):
    if not isinstance(tree, dict | list):
        return []
    inner = tree.values() if isinstance(tree, dict) else tree
    return [tree, *(node for item in inner for node in nodes_of(item))]


def run_family(name, count, seed, folder):
    """Read mutants of one family in a folder of its own; return the counts and faults."""
    (folder := folder / name).mkdir()
    suffix, seeds, read = FAMILIES[name]
    if not seeds:
        table = pd.DataFrame({**CLOUD, "motion_id": ["a", "b", "c", "d"], "status": ["ok"] * 4})
        write_frame(table, folder / "good.parquet", {"made_by": "tests"})
        seeds = [(folder / "good.parquet").read_bytes()]
    chance = random.Random(f"{seed} {name}")
    taken, refused, dearest_s, faults = 0, 0, 0.0, {}
    for number in range(-len(seeds), count):
        path = folder / f"{name}{number}{suffix}"
        is_good = number < 0
        content = seeds[number] if is_good else chance.choice(seeds)
        if not is_good:
            draw = chance.random()
            is_document = draw < 0.65 and suffix in (".yaml", ".json")
            mutated = (of_structure if is_document else of_bytes)(content, chance)
            content = chance.choice(WHOLE) if draw < 0.05 else mutated
        path.write_bytes(content)
        began_s = time.process_time()
        resource.setrlimit(resource.RLIMIT_CPU, (int(began_s) + CPU_LIMIT_S + 1, -1))
        try:
            read(path)
        except InputError as error:
            refused += 1
            message = str(error)
            names_it = name in NAMELESS or path.name in message
            printable = all(sign.isprintable() or sign == "\n" for sign in message)
            if is_good or not (names_it and printable and 0 < len(message) <= LONGEST_MESSAGE):
                faults[path.name] = message[:300]
        except Exception:
            faults[path.name] = traceback.format_exc()[-1500:]
        else:
            taken += not is_good
        dearest_s = max(dearest_s, time.process_time() - began_s)
        if path.name not in faults:
            path.unlink(missing_ok=True)
    return {"taken": taken, "refused": refused, "dearest_s": dearest_s, "faults": faults}


def read_mutants(names, count, seed, folder):
    """Read mutants of families in this process, which keeps the limits."""
    loaded = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (loaded + MEMORY_LIMIT, -1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000_000, -1))
    return {name: run_family(name, count, seed, folder) for name in names}
