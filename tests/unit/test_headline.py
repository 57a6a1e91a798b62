"""The headline of the README is what its stored table says, and that is what a study says."""

from pathlib import Path

import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.errors import InputError
from skewbridge.fragility.old_joint.table import joint_table
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.report import headline

ROOT = Path(__file__).parents[2]
SETTINGS = FitSettings(bootstrap=99)


def test_the_readme_says_what_its_table_says():
    """If not: `make headline` on a finished study writes both."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = headline.headline_text(pd.read_csv(ROOT / headline.DATA))
    assert headline.with_headline(readme, text) == readme


def test_the_headline_comes_from_the_tables_of_a_study(tmp_path):
    demands = synthetic_demands(skews=(0, 30), gaps=(51,), motions=10)
    states = load_limit_states(ROOT / "config" / "limit_states.yaml")
    states = [s for s in states if s.component in ("column_drift", "unseating")]
    curves = fit_study(demands, states, IM, SETTINGS)
    folder = tmp_path / "results" / "fragility"
    folder.mkdir(parents=True)
    paired_effects(demands, settings=SETTINGS).to_parquet(folder / "effects.parquet")
    joint_table(demands, states, IM, curves, SETTINGS).to_parquet(folder / "joint.parquet")
    (tmp_path / "docs" / "images").mkdir(parents=True)
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{headline.BEGIN}\nold\n{headline.END}\nafter\n", encoding="utf-8")
    headline.write_headline(tmp_path / "results", tmp_path)
    stored = pd.read_csv(tmp_path / headline.DATA)
    assert set(stored["axis"]) == {"skew_deg", "friction"}
    assert set(stored["demand"]) == set(headline.DEMANDS)
    text = readme.read_text(encoding="utf-8")
    assert text.startswith("before\n")
    assert text.endswith("\nafter\n")
    assert "old" not in text
    assert "| osb1 | friction 0 to 0.5 |" in text
    row = stored[(stored["axis"] == "friction") & (stored["demand"] == "unseating_m")].iloc[0]
    assert f"{100 * (row['ratio'] - 1):+.1f} (" in text
    assert (tmp_path / headline.PICTURE).stat().st_size > 10_000


def test_a_readme_without_marks_is_refused():
    with pytest.raises(InputError, match="marks"):
        headline.with_headline("nothing", "text")
