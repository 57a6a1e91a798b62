"""An abutment model is a row of traits and a builder; nothing else knows the models by name."""

import ast
from pathlib import Path

import pytest

import skewbridge
from skewbridge.bridge.abutment import BUILDERS
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import Variant, parse_slug

PACKAGE = Path(skewbridge.__file__).parent
# The paper's studies and the drawings may name the paper's models.
FREE_TO_NAME = ("verification", "report")
MODULES = sorted(
    path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] not in FREE_TO_NAME
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
