"""Fragility models of OpenQuake.

References:
    OpenQuake engine manual, fragility models (NRML 0.5, format ``continuous``, shape ``logncdf``;
    its mean and stddev are those of the lognormal variable, not of its logarithm).
"""

import re
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.fragility.exchange.chosen import CURVE_BETA, ChosenCurves
from skewbridge.fragility.exchange.identifiers import identifier
from skewbridge.fragility.exchange.measures import openquake_measure

_NRML: Final = "http://openquake.org/xmlns/nrml/0.5"
_REACH: Final = 4.0  # standard deviations beyond the outermost medians
# source: simple_id of openquake.hazardlib.valid
_ID_SIGNS: Final = r"A-Za-z0-9_:\-"
_LONGEST_ID: Final = 75
#: Negative damage fractions below this are not worth a word.
_CROSSING: Final = 1e-3


def write_nrml(curves: ChosenCurves, out: Path) -> list[dict[str, Any]]:
    """Write one function per variant and component, its limit states by rising threshold.

    A model of OpenQuake has one list of limit states, and every function has all of them. So
    there is one file where all functions have the same states; otherwise one for each component
    and set of states that was fitted, and no curve is dropped.

    Returns:
        Of every file written: ``file``, ``limit_states``, ``functions``, and ``crossing``, the
        functions in which a severer curve lies above a milder one somewhere, so that OpenQuake
        gets a negative fraction of damage there (curves of the method ``ordered`` never cross).

    Raises:
        InputError: The intensity measure has no name in OpenQuake.
        OSError: A file cannot be written.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[pd.DataFrame]] = {}
    for (_, component), part in curves.fitted.groupby(["variant", "component"], sort=True):
        fitted = set(part["limit_state"])
        states = tuple(name for name in curves.states[str(component)] if name in fitted)
        own = part.set_index("limit_state", drop=False).loc[list(states)]
        groups.setdefault((str(component), states), []).append(own)
    alone = len({states for _, states in groups}) == 1
    files: dict[Path, tuple[tuple[str, ...], list[pd.DataFrame]]] = {}
    for (component, states), parts in groups.items():
        whole = len(states) == len(curves.states[component])
        path = out if alone else _beside(out, (component,) if whole else (component, *states))
        files.setdefault(path, (states, []))[1].extend(parts)
    return [_write_file(path, *content, curves.method) for path, content in files.items()]


def _beside(out: Path, names: tuple[str, ...]) -> Path:
    """Return a file in the folder of the file asked for."""
    told = re.sub(r"[^A-Za-z0-9_-]+", "_", "_".join(names))
    return out.with_name(f"{out.stem}_{told}{out.suffix}")


def _write_file(
    path: Path, states: tuple[str, ...], parts: list[pd.DataFrame], method: str
) -> dict[str, Any]:
    ElementTree.register_namespace("", _NRML)
    root = ElementTree.Element(f"{{{_NRML}}}nrml")
    model = _add(root, "fragilityModel", id="skewbridge", assetCategory="bridges")
    model.set("lossCategory", "structural")
    text = f"skewbridge, {method} fits, lognormal; dispersion with that of the capacity"
    _add(model, "description", text)
    _add(model, "limitStates", " ".join(states))
    crossing: list[str] = []
    for part in parts:
        name = f"{part['variant'].iloc[0]}:{part['component'].iloc[0]}"
        name = identifier(name, _ID_SIGNS, _LONGEST_ID)
        if _crosses(part):
            crossing.append(name)
        _add_function(model, name, part)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)
    return {
        "file": str(path),
        "limit_states": list(states),
        "functions": len(parts),
        "crossing": crossing,
    }


def _add_function(model: Element, name: str, part: pd.DataFrame) -> None:
    measure, factor = openquake_measure(str(part["im"].iloc[0]))
    function = _add(model, "fragilityFunction", id=name, format="continuous", shape="logncdf")
    theta, beta = part["theta"].to_numpy() * factor, part[CURVE_BETA].to_numpy()
    reach = np.exp(_REACH * beta.max())
    low, high = f"{theta.min() / reach:.6g}", f"{theta.max() * reach:.6g}"
    _add(function, "imls", imt=measure, noDamageLimit=low, minIML=low, maxIML=high)
    mean = theta * np.exp(0.5 * beta**2)
    deviation = mean * np.sqrt(np.expm1(beta**2))
    for state, m, s in zip(part["limit_state"], mean, deviation, strict=True):
        _add(function, "params", ls=str(state), mean=f"{m:.15g}", stddev=f"{s:.15g}")


def _crosses(part: pd.DataFrame) -> bool:
    """Return whether a severer state is somewhere more probable than a milder one."""
    ln_theta, beta = np.log(part["theta"].to_numpy()), part[CURVE_BETA].to_numpy()
    reach = _REACH * beta.max()
    grid = np.linspace(ln_theta.min() - reach, ln_theta.max() + reach, 400)
    curves = special.ndtr((grid[:, None] - ln_theta) / beta)
    return bool((np.diff(curves, axis=1) > _CROSSING).any())


def _add(parent: Element, tag: str, text: str = "", **values: str) -> Element:
    element = ElementTree.SubElement(parent, f"{{{_NRML}}}{tag}", values)
    element.text = text or None
    return element
