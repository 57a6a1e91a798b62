"""Helpers for small OpenSees models: domain, time-dependent loads, solver and steps."""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from math import ceil, nan
from typing import Any, NamedTuple, Self

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet, UnitLedger, make_step
from skewbridge.errors import SolutionError
from skewbridge.files.tables import Floats

type TimeFunction = Callable[[Floats], Floats]
"""A quantity as a function of an array of times."""


@contextmanager
def clean_domain(dimensions: int, dofs: int) -> Generator[None]:
    """Open an empty OpenSees model; the domain of the process is wiped on entry and exit."""
    ops.wipe()
    ops.model("basic", "-ndm", dimensions, "-ndf", dofs)
    try:
        yield
    finally:
        ops.wipe()


def prepare_analysis(
    *,
    constraints: str = "Transformation",
    numberer: str = "Plain",
    system: str = "FullGeneral",
    tolerance_m: float = 1e-12,
    algorithm: str = "NewtonLineSearch",
    integrator: tuple[str | float, ...] = ("Newmark", 0.5, 0.25),
    analysis: str = "Transient",
) -> None:
    """Define the analysis; the tolerance limits the norm of the last displacement increment."""
    ops.constraints(constraints)
    ops.numberer(numberer)
    ops.system(system)
    ops.test("NormDispIncr", tolerance_m, 50)
    ops.algorithm(algorithm)
    ops.integrator(*integrator)
    ops.analysis(analysis)


def path_series(tag: int, dt_s: float, values: Floats) -> None:
    """Define a time series with a constant step; it keeps the last value after its end."""
    ops.timeSeries("Path", tag, "-dt", dt_s, "-values", *values.tolist(), float(values[-1]))


def load_node(
    node: int, weight_n: float, dt_s: float, force_n: Floats, *, rotations: int = 0
) -> None:
    """Load a node by a constant weight along -y and a time-dependent force along x."""
    no_moments = [0.0] * rotations
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(node, 0.0, -weight_n, *no_moments)
    path_series(2, dt_s, force_n)
    ops.pattern("Plain", 2, 2)
    ops.load(node, 1.0, 0.0, *no_moments)


class History(NamedTuple):
    """Displacements and velocities of a model (n, dofs), and states of its contacts (n, units).

    Openings are negative in contact; friction has the sign of slip. A deck has q = (ux, uy, theta)
    and the residual of its energy over the largest input.
    """

    t_s: Floats
    q: Floats
    v: Floats
    openings_m: Floats
    normals_n: Floats
    tangentials_n: Floats
    ledgers: Sequence[UnitLedger] = ()
    energy_residual_ratio: float = nan

    def at(self, rows: Any) -> Self:
        """Return the states at some rows (indices or a slice)."""
        return self._replace(**{name: getattr(self, name)[rows] for name in self._fields[:6]})

    def peaks(self) -> dict[str, float]:
        """Return the largest magnitudes of ux, uy and theta, and the deepest penetration."""
        ux, uy, theta = (float(peak) for peak in np.abs(self.q).max(axis=0))
        penetration = max(0.0, float(-self.openings_m.min()))
        return {"ux_m": ux, "uy_m": uy, "theta_rad": theta, "penetration_m": penetration}

    def first_contact_s(self) -> float | None:
        """Return the interpolated time (s) when the first gap closes; None if all stay open.

        Rigid contact (LCP) has no penetration: its first step with a force is returned. A gap that
        closes by rounding after this step does not count.
        """
        crossing_s = first_crossing_s(self.t_s, self.openings_m.min(axis=1))
        times_s = crossing_s, *self.t_s[self.normals_n.max(axis=1) > 0.0][:1].tolist()
        return min((time_s for time_s in times_s if time_s is not None), default=None)


def first_crossing_s(t_s: Floats, values: Floats) -> float | None:
    """Return the interpolated time (s) when values first become negative, or None."""
    k = int(np.argmax(values < 0.0))
    if values[k] >= 0.0:
        return None
    if k == 0:
        return float(t_s[0])
    share = values[k - 1] / (values[k - 1] - values[k])
    return float(t_s[k - 1] + share * (t_s[k] - t_s[k - 1]))


def cone_excess(friction_n: Floats, normal_n: Floats, coefficient: float) -> float:
    """Return (largest excess of friction over Coulomb's limit) / largest limit."""
    excess = np.abs(friction_n) - coefficient * np.maximum(0.0, normal_n)
    return max(0.0, float(excess.max())) / (coefficient * float(normal_n.max()))


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def even_times(duration_s: float, dt_s: float) -> Floats:
    """Return times with equal steps from zero to the end or the first time after it."""
    return np.arange(ceil(duration_s / dt_s - 1e-9) + 1, dtype=np.float64) * dt_s


def record(
    contacts: ContactSet,
    times_s: Floats,
    dt_s: float,
    nodes: Sequence[int],
    signs: Sequence[float],
    parts_on_change: int = 1,
) -> History:
    """Step through the given times; return motions of nodes and openings and forces of contacts.

    Columns follow the order of ``nodes``. ``signs`` has 1 for a unit whose slip is positive along
    its normal turned by 90 degrees counter-clockwise, else -1.
    """

    def state() -> tuple[list[float], ...]:
        q, v = ([x for n in nodes for x in read(n)] for read in (ops.nodeDisp, ops.nodeVel))
        slips = [s * along for s, (along, _) in zip(signs, contacts.tangentials_n, strict=True)]
        return q, v, contacts.openings_m, contacts.normals_n, slips

    rows = [state()]
    for time_s in times_s[1:].tolist():
        if not make_step(contacts, dt_s, parts_on_change=parts_on_change):
            raise SolutionError(f"no convergence at {time_s:.6g} s of {times_s[-1]:.6g} s")
        rows.append(state())
    return History(times_s, *map(np.array, zip(*rows, strict=True)), ledgers=contacts.ledger())
