"""Small reference files in `tests/data`, each with its source; bad values and their messages."""

import json
from functools import cache
from pathlib import Path

import pandas as pd

from skewbridge.files.text import read_yaml

DATA = Path(__file__).parent / "data"
BAD = read_yaml(DATA.parent / "unit/bad_values.yaml")


@cache
def reference_table(name):
    return pd.read_csv(DATA / f"{name}.csv", comment="#")


def fragility_case(name):
    found = json.loads((DATA / "fragility_cases.json").read_text(encoding="utf-8"))[name]
    return found["input"], found["expected"]
