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
from typing import Final

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.monitor import Monitor
from skewbridge.analysis.trace import DISP
from skewbridge.bridge.handles import BridgeModel
from skewbridge.units import KJ

type Matrix = NDArray[np.float64]
type GroundAccel = Callable[[Matrix], Matrix]

_CHUNK: Final = 500  # rows between two evaluations: memory stays flat
_STRIDE: Final = 2  # half the cost; the balance closes to 1 % of the input instead of 0.02 %
# Elements of no length: the force on the first node is that on the second, reversed.
_JOINTS: Final = ("bearings", "backfill")


@dataclass(frozen=True, slots=True, kw_only=True)
class _EndState:
    """Energies that only the first and the last state need: kinetic, of position, of links."""

    kinetic_j: float
    gravity_j: float
    links: dict[int, tuple[Matrix, Matrix]]


class EnergyBalance:
    """Collects forces and velocities step by step and adds up their works.

    Args:
        model: Under gravity.
        monitor: Reads the displacements; one row before each call of `collect`.
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
        damped = {node for element in model.damping_elements for node in ops.eleNodes(element)}
        self._damped = tuple(node for node in self._masses if node in damped)
        self._groups = {name: groups[name] for name in ("columns", "deck", *_JOINTS)}
        self._ends = {
            element: tuple(int(node) for node in ops.eleNodes(element))
            for elements in self._groups.values()
            for element in elements
        }
        self._joints = tuple(element for name in _JOINTS for element in groups[name])
        self._links = groups["links"]
        self._values = array("d")
        self._kept: list[int] = []  # numbers of the rows read and not yet evaluated
        self._works: dict[str, float] = dict.fromkeys(
            ("input", "inertia", "damping", "columns", "deck", "bearings", "backfill"), 0.0
        )
        self._largest_input = 0.0
        self._start = self._end_state()
        self._read()

    def collect(self) -> None:
        """Read what belongs to the monitor's last row; of every second row only."""
        if self._monitor.count - self._kept[-1] >= _STRIDE:
            self._read()

    def _read(self) -> None:
        self._kept.append(self._monitor.count)
        row: list[float] = []
        acceleration, velocity = ops.nodeAccel, ops.nodeVel
        for node in self._masses:
            row += acceleration(node)
        for node in self._damped:
            row += velocity(node)
        dynamic, static = ops.eleDynamicalForce, ops.eleForce
        for element in self._groups["columns"]:
            row += static(element)
            row += dynamic(element)
        for element in self._groups["deck"]:
            row += static(element)
        for element in self._joints:
            row += static(element)[DISP:]
        self._values.extend(row)
        if len(self._kept) > _CHUNK:
            self._evaluate()

    def terms_kj(self) -> dict[str, float]:
        """Return the balance so far, in kJ, with ``residual`` and ``largest_input``."""
        if self._kept[-1] != self._monitor.count:
            self._read()
        if len(self._kept) > 1:
            self._evaluate()
        end = self._end_state()
        works = self._works | {"kinetic": end.kinetic_j - self._start.kinetic_j}
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
        values = np.array(self._values).reshape(len(self._kept), -1)
        rows = self._monitor.rows(self._kept)
        self._add_masses(values, rows)
        self._add_members(values, rows)
        self._values = array("d", values[-1].tolist())
        self._kept = self._kept[-1:]

    def _add_masses(self, values: Matrix, rows: Matrix) -> None:
        """Add input, inertia and mass-proportional damping."""
        works, ground, layout = self._works, self._ground(rows[:, 0]), self._monitor.layout
        inputs = np.zeros(len(rows) - 1)
        for at, (node, mass) in enumerate(self._masses.items()):
            disp = layout.disp(rows, node)
            inputs -= _steps(mass[:2] * ground, disp[:, :2])
            works["inertia"] += _steps(mass * _block(values, at), disp).sum()
        for at, node in enumerate(self._damped, start=len(self._masses)):
            drag = self._mass_factor * self._masses[node] * _block(values, at)
            works["damping"] += _steps(drag, layout.disp(rows, node)).sum()
        sums = works["input"] + np.cumsum(inputs)
        self._largest_input = max(self._largest_input, float(np.abs(sums).max()))
        works["input"] = float(sums[-1])

    def _add_members(self, values: Matrix, rows: Matrix) -> None:
        """Add the works of members, pads and soil, and stiffness-proportional damping."""
        works = self._works
        at = len(self._masses) + len(self._damped)
        for element in self._groups["columns"]:
            static, dynamic = _block(values, at, 2), _block(values, at + 2, 2)
            at += 4
            moved = self._moved(element, rows)
            works["columns"] += _steps(static, moved).sum()
            works["damping"] += _steps(dynamic - static, moved).sum()
        for element in self._groups["deck"]:
            static = _block(values, at, 2)
            at += 2
            moved = self._moved(element, rows)
            works["deck"] += _steps(static, moved).sum()
            # Elastic: the rate of the stiffness-proportional force is that of the force itself.
            rates = np.diff(static, axis=0) * np.diff(moved, axis=0)
            works["damping"] += (
                self._stiffness_factor * (rates / np.diff(rows[:, :1], axis=0)).sum()
            )
        for name in _JOINTS:
            for element in self._groups[name]:
                moved = self._moved(element, rows)
                works[name] += _steps(_block(values, at), moved[:, DISP:] - moved[:, :DISP]).sum()
                at += 1

    def _moved(self, element: int, rows: Matrix) -> Matrix:
        """Return the displacements of both ends of a member, shape (n, 12)."""
        layout = self._monitor.layout
        return np.hstack([layout.disp(rows, node) for node in self._ends[element]])

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


def contact_energy_ratio(terms: Mapping[str, float]) -> float:
    """Return what the normal springs of the contacts took and do not store over the largest input.

    Negative if they made energy; nan without a balance. Slip, which always takes energy and would
    hide it, is left out.
    """
    if not terms or not terms["largest_input"] > 0.0:
        return float("nan")
    return terms["contact_quadrature"] / terms["largest_input"]


def _steps(force: Matrix, moved: Matrix) -> Matrix:
    """Return the work of each step, shape (n - 1,), summed over the components."""
    return 0.5 * ((force[1:] + force[:-1]) * np.diff(moved, axis=0)).sum(axis=1)


def _block(values: Matrix, at: int, ends: int = 1) -> Matrix:
    """Return the six columns of a node or an element's end, or those of both ends."""
    return values[:, DISP * at : DISP * (at + ends)]


def _masses(nodes: Iterable[int]) -> dict[int, Matrix]:
    """Return the six masses of each node that has any."""
    masses = {node: np.array(ops.nodeMass(node), dtype=np.float64) for node in nodes}
    return {node: mass for node, mass in masses.items() if mass.any()}
