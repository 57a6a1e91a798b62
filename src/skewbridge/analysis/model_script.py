"""Export of a variant as a plain OpenSeesPy script that does not need this package."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import wraps
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

# Commands that change the domain or drive the analysis; queries are not part of a model.
RECORDED: Final = (
    "wipe", "model", "node", "fix", "mass", "uniaxialMaterial", "section", "fiber", "geomTransf",
    "beamIntegration", "element", "rigidLink", "equalDOF", "timeSeries", "pattern", "load", "sp",
    "remove", "region", "rayleigh", "parameter", "addToParameter", "updateParameter", "constraints",
    "numberer", "system", "test", "algorithm", "integrator", "analysis", "analyze", "loadConst",
    "wipeAnalysis", "domainChange", "setElementRayleighDampingFactors", "setNodeAccel",
)  # fmt: skip
HEADER: Final = '''"""{title}

OpenSees commands of one model, written by skewbridge; they run without it. Units are N, m, s, kg.
The x axis is along the bridge, y across it, z up. Contact pairs are the zeroLength elements with
three materials (ElasticPPGap, ElasticPP, ElasticPP) and four parameters each. Update their friction
bounds (parameter `Fy`) after every step; see the documentation of skewbridge.contact.
"""

import openseespy.opensees as ops

'''


def model_script(variant: Variant, options: ModelOptions) -> str:
    """Return a script of a variant at rest under gravity, with damping and its contacts."""
    with recording() as record, domain():
        model = build(variant, options)
        apply_rayleigh(model)
        commands = HEADER.format(title=variant.normalised().slug) + "\n".join(record)
        return f"{commands}\n{_contact_table(model)}"


def _contact_table(model: BridgeModel) -> str:
    """Return Python source of a list of contacts; ``bounds`` are their friction parameters."""
    if model.contacts is None:
        return ""
    rows = [
        f"    dict(name={unit.name!r}, element={unit.element}, node_i={unit.node_i}, "
        f"node_j={unit.node_j}, bounds={unit.springs.bounds}, gap_m={unit.gap_m!r}, "
        f"kn={unit.kn!r}, kt={unit.kt!r}, friction={unit.friction!r}, "
        f"cohesion_n={unit.cohesion!r}),"
        for unit in model.contacts.units
    ]
    return "\n".join(["", "CONTACTS = [", *rows, "]", ""])


@contextmanager
def recording() -> Generator[list[str]]:
    """Record every OpenSees command that is called inside the block, in order."""
    record: list[str] = []
    originals = {name: getattr(ops, name) for name in RECORDED}

    def listening(name: str, command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def recorded(*arguments: Any) -> Any:
            record.append(f"ops.{name}({', '.join(map(_literal, arguments))})")
            return command(*arguments)

        return recorded

    for name, command in originals.items():
        setattr(ops, name, listening(name, command))
    try:
        yield record
    finally:
        for name, command in originals.items():
            setattr(ops, name, command)


def _literal(value: Any) -> str:
    if isinstance(value, bool | int | str):
        return repr(value)
    return repr(float(value))  # repr of a float reads back to the same bits
