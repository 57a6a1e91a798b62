"""The recorded script builds the same model without the package."""

import json
import subprocess
import sys
from pathlib import Path

import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.model_script import model_script, recording
from skewbridge.bridge.model import DomainError, build, domain
from skewbridge.variant.options import ModelOptions

VARIANT = variant()

ASK = """
import json
print(json.dumps([[n, *ops.nodeDisp(n)] for n in ops.getNodeTags()] + [ops.getEleTags()]))
"""


def test_the_script_repeats_the_model_to_the_bit(tmp_path: Path) -> None:
    script = tmp_path / "model.py"
    text = model_script(VARIANT, ModelOptions())
    script.write_text(text + ASK, encoding="utf-8")
    assert "skewbridge." not in text.replace("skewbridge.contact.", "")  # named in the docstring
    answer = subprocess.run(
        [sys.executable, "-I", str(script)], capture_output=True, text=True, check=True
    )
    with domain():
        build(VARIANT, ModelOptions())
        expected = [[n, *ops.nodeDisp(n)] for n in ops.getNodeTags()]
        expected.append(ops.getEleTags())
    assert json.loads(answer.stdout.strip().split("\n")[-1]) == expected
    assert text.count("dict(name=") == 2 * (3 + 2)  # wall points and keys


def test_recording_leaves_the_commands_as_they_were() -> None:
    before = ops.node
    with recording():
        assert ops.node is not before
    assert ops.node is before


def test_a_model_is_built_only_in_a_fresh_domain() -> None:
    with domain():
        build(VARIANT, ModelOptions())
        with pytest.raises(DomainError):
            build(VARIANT, ModelOptions())
    assert not ops.getNodeTags()
