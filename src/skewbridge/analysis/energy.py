"""Energy balance of an analysis, by the trapezoidal rule on forces at the ends of the steps.

Every work comes from forces read from elements, masses and dashpots, never as a difference, so
that the residual checks the equilibrium of the whole model::

    input + gravity = inertia + damping + columns + deck + bearings + backfill + contact + links
                      + residual

The part of ``inertia`` that is no change of kinetic energy is what the integrator dissipates
(``algorithmic``).
"""

from array import array
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.monitor import Monitor
from skewbridge.bridge.handles import BridgeModel
from skewbridge.units import KJ

type Matrix = NDArray[np.float64]
type GroundAccel = Callable[[Matrix], Matrix]

_CHUNK = 500  # steps between two evaluations: memory stays flat
_DISP = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class _EndState:
    """Energies that only the first and the last state need: kinetic, of position, of links."""

    kinetic_j: float
    gravity_j: float
    links: dict[int, tuple[Matrix, Matrix]]


class EnergyBalance:
    """Collects forces and velocities step by step and adds up their works.

    Args:
        model: Handles of the model, under gravity.
        monitor: Reads the displacements; one row per call of `collect`, the first before it.
        ground_accel_mps2: Function of times, shape (n,), giving accelerations, shape (n, 2).
        rayleigh: Mass and (committed) stiffness factors of the damped region.
    """

    def __init__(
        self,
        model: BridgeModel,
        monitor: Monitor,
        ground_accel_mps2: GroundAccel,
        rayleigh: tuple[float, float],
    ) -> None:
        groups = model.energy_elements
        self._model, self._monitor, self._ground = model, monitor, ground_accel_mps2
        self._mass_factor, self._stiffness_factor = rayleigh
        self._masses = _masses(monitor.layout.nodes)
        self._damped = _nodes_of(model.damping_elements)
        self._columns = groups["columns"]
        self._deck = groups["deck"]
        self._links = groups["links"]
        self._basic = {
            name: tuple((e, len(ops.basicForce(e))) for e in groups[name])
            for name in ("bearings", "backfill")
        }
        self._values = array("d")
        self._pending = 0
        self._works: dict[str, float] = dict.fromkeys(
            ("input", "inertia", "damping", "columns", "deck", "bearings", "backfill"), 0.0
        )
        self._largest_input = 0.0
        self._start = self._end_state()
        self.collect()
        self._pending = 0

    def collect(self) -> None:
        """Read what belongs to the monitor's last row."""
        row: list[float] = []
        velocity, acceleration = ops.nodeVel, ops.nodeAccel
        for node in self._masses:
            row += velocity(node)
            row += acceleration(node)
        dynamic, static = ops.eleDynamicalForce, ops.eleForce
        for element in self._columns:
            row += dynamic(element)
            row += static(element)
        for element in self._deck:
            row += static(element)
        force, deformation = ops.basicForce, ops.basicDeformation
        for elements in self._basic.values():
            for element, _ in elements:
                row += force(element)
                row += deformation(element)
        self._values.extend(row)
        self._pending += 1
        if self._pending == _CHUNK:
            self._evaluate()

    def terms_kj(self) -> dict[str, float]:
        """Return the balance so far, in kJ, with ``residual`` and ``largest_input``."""
        if self._pending:
            self._evaluate()
        end = self._end_state()
        works = dict(self._works)
        works["kinetic"] = end.kinetic_j - self._start.kinetic_j
        works["algorithmic"] = works["inertia"] - works["kinetic"]
        works["gravity"] = end.gravity_j - self._start.gravity_j
        works["links"] = self._link_work(end)
        works["contact"], works["slip"], works["contact_quadrature"] = self._contact_works()
        sinks = ("inertia", "damping", "columns", "deck", "bearings", "backfill", "contact")
        works["residual"] = (
            works["input"] + works["gravity"] - works["links"] - sum(works[n] for n in sinks)
        )
        works["largest_input"] = self._largest_input
        return {name: float(value) / KJ for name, value in works.items()}

    def _evaluate(self) -> None:
        """Add the works of the pending steps; the last state stays as the next start."""
        count = self._pending + 1
        values = np.array(self._values).reshape(count, -1)
        rows = self._monitor.last_rows(count)
        layout = self._monitor.layout
        disp = {
            node: rows[:, layout.node(node) : layout.node(node) + _DISP] for node in layout.nodes
        }
        times = rows[:, 0]
        ground = self._ground(times)
        inputs = np.zeros(count - 1)
        works = self._works
        at = 0
        for node, mass in self._masses.items():
            velocity, acceleration = values[:, at : at + 6], values[:, at + 6 : at + 12]
            at += 12
            inputs -= _steps(mass[:2] * ground, disp[node][:, :2])
            works["inertia"] += _steps(mass * acceleration, disp[node]).sum()
            if node in self._damped:
                drag = self._mass_factor * mass * velocity
                works["damping"] += _steps(drag, disp[node]).sum()
        for element in self._columns:
            dynamic, static = values[:, at : at + 12], values[:, at + 12 : at + 24]
            at += 24
            moved = self._ends(element, disp)
            works["columns"] += _steps(static, moved).sum()
            works["damping"] += _steps(dynamic - static, moved).sum()
        for element in self._deck:
            static = values[:, at : at + 12]
            at += 12
            moved = self._ends(element, disp)
            works["deck"] += _steps(static, moved).sum()
            # Elastic: the rate of the stiffness-proportional force is that of the force itself.
            rates = np.diff(static, axis=0) * np.diff(moved, axis=0) / np.diff(times)[:, None]
            works["damping"] += self._stiffness_factor * rates.sum()
        for name, elements in self._basic.items():
            for _, size in elements:
                force = values[:, at : at + size]
                deformation = values[:, at + size : at + 2 * size]
                at += 2 * size
                works[name] += _steps(force, deformation).sum()
        sums = self._works["input"] + np.cumsum(inputs)
        self._largest_input = max(self._largest_input, float(np.abs(sums).max()))
        works["input"] = float(sums[-1])
        self._values = array("d", values[-1].tolist())
        self._pending = 0

    def _ends(self, element: int, disp: dict[int, Matrix]) -> Matrix:
        """Return the displacements of both ends of a member, shape (n, 12)."""
        count = len(next(iter(disp.values())))
        fixed = np.zeros((count, _DISP))
        return np.hstack([disp.get(node, fixed) for node in ops.eleNodes(element)])

    def _end_state(self) -> _EndState:
        kinetic = sum(
            0.5 * float(np.dot(mass, np.square(ops.nodeVel(node))))
            for node, mass in self._masses.items()
        )
        gravity = -sum(
            load * ops.nodeDisp(node, 3) for node, load in self._model.dead_loads_n.items()
        )
        links = {
            element: (
                np.array(ops.eleForce(element)),
                np.hstack([ops.nodeDisp(node) for node in ops.eleNodes(element)]),
            )
            for element in self._links
        }
        return _EndState(kinetic_j=kinetic, gravity_j=gravity, links=links)

    def _link_work(self, end: _EndState) -> float:
        """Return the work of elastic links between the two states, exact for linear ones."""
        work = 0.0
        for element, (force, disp) in end.links.items():
            force_before, disp_before = self._start.links[element]
            work += 0.5 * float((force + force_before) @ (disp - disp_before))
        return work

    def _contact_works(self) -> tuple[float, float, float]:
        """Return work on all contact springs, work of slip, and the quadrature of the normals."""
        contacts = self._model.contacts
        if contacts is None:
            return 0.0, 0.0, 0.0
        ledger = contacts.ledger()
        slip = sum(unit.slip_work_j for unit in ledger)
        normal = sum(unit.normal_work_j for unit in ledger)
        stored = sum(
            0.5 * (t1 * t1 + t2 * t2) / unit.kt
            for unit, (t1, t2) in zip(contacts.units, contacts.tangentials_n, strict=True)
        )
        potential = sum(unit.normal_potential_j for unit in ledger)
        return normal + slip + stored, slip, normal - potential


def energy_residual_ratio(terms: Mapping[str, float]) -> float:
    """Return what is not accounted for over the largest input; nan without a balance."""
    if not terms or not terms["largest_input"] > 0.0:
        return float("nan")
    return terms["residual"] / terms["largest_input"]


def _steps(force: Matrix, moved: Matrix) -> Matrix:
    """Return the work of each step, shape (n - 1,), summed over the components."""
    return 0.5 * ((force[1:] + force[:-1]) * np.diff(moved, axis=0)).sum(axis=1)


def _masses(nodes: Iterable[int]) -> dict[int, Matrix]:
    """Return the six masses of each node that has any."""
    masses = {node: np.array(ops.nodeMass(node), dtype=np.float64) for node in nodes}
    return {node: mass for node, mass in masses.items() if mass.any()}


def _nodes_of(elements: Iterable[int]) -> frozenset[int]:
    return frozenset(node for element in elements for node in ops.eleNodes(element))
