"""A model as a plain OpenSeesPy script: the commands that built it, recorded."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import wraps
from typing import Any, Final

import openseespy.opensees as ops

# Commands that change the domain or drive the analysis; queries are not part of a model.
RECORDED: Final = (
    "wipe", "model", "node", "fix", "mass", "uniaxialMaterial", "section", "fiber", "geomTransf",
    "beamIntegration", "element", "rigidLink", "equalDOF", "timeSeries", "pattern", "load", "sp",
    "remove", "region", "rayleigh", "parameter", "addToParameter", "updateParameter", "constraints",
    "numberer", "system", "test", "algorithm", "integrator", "analysis", "analyze", "loadConst",
    "wipeAnalysis",
)  # fmt: skip

HEADER: Final = '''"""{title}

Written by skewbridge: the commands of one model, without the package. Units N, m, s, kg; x along
the bridge, y across, z up. Contact pairs are the zeroLength elements with three materials
(ElasticPPGap, ElasticPP, ElasticPP) and four parameters each; their friction bounds are to be
updated after every step (parameter `Fy`), see the documentation of skewbridge.contact.
"""

import openseespy.opensees as ops

'''


class Recording(list[str]):
    """The commands of a `recording()` block, in order."""

    def script(self, title: str) -> str:
        """Return a script that repeats the commands."""
        return HEADER.format(title=title) + "\n".join(self) + "\n"


@contextmanager
def recording() -> Generator[Recording]:
    """Record every command that is given inside the block, whoever gives it."""
    record = Recording()
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
