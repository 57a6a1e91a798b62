"""An abutment model is a row of traits and a builder; no other code uses its name."""

import ast
from pathlib import Path

import pandas as pd
import pytest

import skewbridge
from skewbridge.bridge.abutment import BUILDERS
from skewbridge.report.checks import contact_differences
from skewbridge.report.methods import methods_of
from skewbridge.study.config import parse_config
from skewbridge.variant.abutments import ABUTMENTS, AbutmentTraits
from skewbridge.variant.variant import Variant, parse_slug

PACKAGE = Path(skewbridge.__file__).parent
# The paper's studies may name the paper's models; drawings name groups of elements.
MAY_NAME_MODELS = ("verification/", "report/bridge_figures.py")
MODULES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if not path.relative_to(PACKAGE).as_posix().startswith(MAY_NAME_MODELS)
)


def test_every_model_has_a_builder_and_a_code_of_its_own():
    assert BUILDERS.keys() == ABUTMENTS.keys()
    assert len({traits.code for traits in ABUTMENTS.values()}) == len(ABUTMENTS)


@pytest.mark.parametrize("name", ABUTMENTS)
def test_a_variant_keeps_the_axes_of_its_model_only(name):
    full = Variant(bridge="osb1", abutment=name, skew_deg=30, gap_mm=51, friction_pct=50)
    axes = ABUTMENTS[name].axes
    own = full.normalised()
    assert own.gap_mm == (51 if "gap_mm" in axes else 0)
    assert own.friction_pct == (50 if "friction" in axes else 0)
    assert parse_slug(own.slug) == own


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_module_compares_with_the_name_of_a_model(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Compare):
            texts = {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)}
            assert not texts & set(ABUTMENTS), ast.unparse(node)


@pytest.mark.parametrize(
    ("traits", "stated", "not_stated"),
    [
        ({"backfill": "none"}, [], ["backfill is", "Contact is"]),
        ({"backfill": "option"}, ["The backfill is hyperbolic"], ["Contact is"]),
        (
            {"backfill": "none", "has_contacts": True},
            ["Contact is", "points are placed"],
            ["backfill is"],
        ),
    ],
)
def test_the_report_describes_a_further_model_by_its_traits(
    monkeypatch, traits, stated, not_stated
):
    further = AbutmentTraits(code="fu", description="as springs of a further model", **traits)
    monkeypatch.setitem(ABUTMENTS, "further", further)
    text = methods_of(parse_config({"grid": {"abutment": ["further"]}})).parts["Abutments"]
    for part in ["modelled as springs of a further model", *stated]:
        assert part in text
    for part in not_stated:
        assert part not in text


def test_a_further_friction_model_is_compared_with_its_model_without_friction(monkeypatch):
    further = AbutmentTraits(code="fu", description="", without_friction="spring")
    monkeypatch.setitem(ABUTMENTS, "further", further)
    run = {"bridge": "osb1", "skew_deg": 30, "gap_mm": 51, "friction": 0.0}
    run |= {"motion_id": "a", "scale": 1.0, "incidence_deg": 0.0}
    rows = [
        run | {"abutment": "further", "deck_disp_m": 0.2},
        run | {"abutment": "spring", "deck_disp_m": 0.3},
    ]
    table = pd.DataFrame(rows)
    assert contact_differences(table, table)["abutment"].tolist() == ["further"]
    assert contact_differences(table, table.assign(deck_disp_m=0.2)).empty
