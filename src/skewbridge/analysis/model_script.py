"""Export of a variant as a plain OpenSeesPy script that does not need this package."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from typing import Any, Final

import openseespy.opensees as ops

from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.script_units import UnitSystem
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

OpenSees commands of one model, written by skewbridge; they run without it. Their unit of force is
{force_n:.10g} N, that of length {length_m:.10g} m; CONTACTS is in N and m. The x axis is along the
bridge, y across it, z up. Contact pairs are zeroLength elements with the materials ElasticPPGap,
ElasticPP and ElasticPP. Update their friction bounds (parameter `Fy`) after every step; see the
documentation of skewbridge.contact. `eigen` uses the full stiffness of a friction spring even if
its bound is zero: for modes with open gaps, first set the parameters `moduli` to nearly zero.
"""

import openseespy.opensees as ops

'''


def model_script(variant: Variant, options: ModelOptions) -> str:
    """Return a script of a variant at rest under gravity, with damping and its contacts."""
    with recording() as record, domain():
        model = build(variant, options)
        apply_rayleigh(model)
        units = asdict(model.frame.units or UnitSystem())
        commands = HEADER.format(title=variant.normalised().slug, **units) + "\n".join(record)
        return f"{commands}\n{_contact_table(model)}"


def _contact_table(model: BridgeModel) -> str:
    """Return Python source of a list of contacts; ``bounds`` are their friction parameters."""
    if model.contacts is None:
        return ""
    rows = [
        f"    dict(name={unit.name!r}, element={unit.element}, node_i={unit.node_i}, "
        f"node_j={unit.node_j}, moduli={unit.springs.moduli}, bounds={unit.springs.bounds}, "
        f"gap_m={unit.gap_m!r}, kn={unit.kn!r}, kt={unit.kt!r}, friction={unit.friction!r}, "
        f"cohesion_n={unit.cohesion!r}),"
        for unit in model.contacts.units
    ]
    return "\n".join(["", "CONTACTS = [", *rows, "]", ""])


@contextmanager
def recording() -> Generator[list[str]]:
    """Record every OpenSees command that is called inside the block, in order."""
    record: list[str] = []
    originals = {name: getattr(ops, name) for name in RECORDED}

    def recorded(name: str, *arguments: Any) -> Any:
        record.append(f"ops.{name}({', '.join(map(_literal, arguments))})")
        return originals[name](*arguments)

    for name in originals:
        setattr(ops, name, partial(recorded, name))
    try:
        yield record
    finally:
        for name, command in originals.items():
            setattr(ops, name, command)


def _literal(value: Any) -> str:
    if isinstance(value, bool | int | str):
        return repr(value)
    return repr(float(value))  # repr of a float reads back to the same bits
