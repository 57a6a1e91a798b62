"""Energy balance of an analysis: work of step-end forces, integrated by the trapezoidal rule.

The balance::

    input + gravity = kinetic + numerical + damping + columns + deck + bearings + backfill
                      + contact + links + residual

The work of a force in a step is (f_n + f_n+1) / 2 times the increment of displacement. Under the
trapezoidal rule (Newmark 1/2, 1/4), the work of the inertia forces is exactly the change of
kinetic energy for any step size, and `residual` is the error that the convergence test allows. For
any other integrator, `numerical` is the work of the unbalanced forces G = P - C v - F minus the
change of kinetic energy: the energy that the integrator dissipates. No term is defined as the
remainder of the balance, so the residual checks the equilibrium of the model.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.settings import OpenSeesCommand
from skewbridge.analysis.trace import DISP, Monitor, ResponseTrace, Series
from skewbridge.bridge.frame import BridgeModel
from skewbridge.units import KJ

type GroundAccel = Callable[[Series], Series]
_TRAPEZOIDAL: Final = ("Newmark", 0.5, 0.25)
_TERMS: Final = (
    "kinetic", "numerical", "damping", "columns", "deck", "bearings", "backfill", "contact",
    "links",
)  # fmt: skip


class _EndState(NamedTuple):
    """Energies, and forces and displacements of linear elements, in the first or last state."""

    kinetic_j: float
    gravity_j: float
    elastic: dict[int, tuple[Series, Series]]


class EnergyBalance:
    """Energy balance of one analysis; it also records the forces that only the balance needs.

    Create it before the monitor starts. ``ground_accel_mps2`` maps times (n,) to (n, 2);
    ``rayleigh`` has the mass (1/s) and stiffness (s) factors.
    """

    def __init__(
        self,
        model: BridgeModel,
        monitor: Monitor,
        ground_accel_mps2: GroundAccel,
        rayleigh: tuple[float, float],
        integrator: OpenSeesCommand,
    ) -> None:
        groups = model.energy_elements
        self._model, self._monitor, self._ground = model, monitor, ground_accel_mps2
        self._mass_factor, self._stiffness_factor = rayleigh
        self._integrator = integrator
        masses = {node: np.array(ops.nodeMass(node), dtype=np.float64) for node in monitor.nodes}
        self._masses = {node: mass for node, mass in masses.items() if mass.any()}
        damped = {
            node for element in model.frame.damping.elements for node in ops.eleNodes(element)
        }
        self._damped = tuple(node for node in self._masses if node in damped)
        self._columns = groups["columns"]
        # elastic beams do not report the forces of their Rayleigh damping
        elastic = [tag for tag in self._columns if ops.eleType(tag) == "ElasticBeam3d"]
        damped_columns = set(self._columns).intersection(model.frame.damping.elements)
        self._stiffness = {tag: elastic_stiffness(tag) for tag in (*groups["deck"], *elastic)}
        self._at_walls = held_by_contacts(model)
        at_walls = {element for elements in self._at_walls.values() for element in elements}
        self._joints = {
            name: tuple(element for element in groups[name] if element not in at_walls)
            for name in ("bearings", "backfill")
        }
        self._read_joints = tuple(element for joints in self._joints.values() for element in joints)
        is_exact = integrator[:3] == _TRAPEZOIDAL
        self._accelerated = () if is_exact else tuple(self._masses)
        self._nodes = {
            element: tuple(int(node) for node in ops.eleNodes(element))
            for element in (*self._columns, *self._stiffness, *self._read_joints)
        }
        self._elastic = {name: groups[name] for name in ("deck", "links")}
        recorder = monitor.recorder
        recorder.elements(sorted(damped_columns.difference(elastic)), "rayleighForces")
        recorder.elements(self._read_joints, "force")
        recorder.nodes(self._accelerated, "accel")
        self._start = self._end_state()

    def terms_kj(self) -> dict[str, float]:
        """Stop recording; return the terms in kJ, with ``residual`` and ``largest_input``."""
        end_state, extra = self._end_state(), self._monitor.extra
        trace = self._monitor.trace()
        mass_u = sum(mass[:2] * trace.position(node)[:, :2] for node, mass in self._masses.items())
        input_j = np.cumsum(-_steps(self._ground(trace.time_s), np.asarray(mass_u)))
        works = {
            "input": input_j[-1] if len(input_j) else 0.0,
            "gravity": end_state.gravity_j - self._start.gravity_j,
            "kinetic": end_state.kinetic_j - self._start.kinetic_j,
            "damping": self._damping(trace, extra("Element", "rayleighForces")),
            "columns": sum(
                _work(trace.columns[element], self._moved(element, trace))
                for element in self._columns
            ),
            **{name: self._elastic_work(name, end_state) for name in self._elastic},
            **self._joint_works(trace, extra("Element", "force")),
        }
        works["backfill"] += self._wall_work(trace)
        works["numerical"] = 0.0
        if self._accelerated:
            works["numerical"] = (
                self._unbalanced_work(trace, extra("Node", "accel")) - works["kinetic"]
            )
        works["contact"], works["slip"], works["contact_quadrature"] = self._contact_works()
        works["residual"] = works["input"] + works["gravity"] - sum(works[name] for name in _TERMS)
        works["largest_input"] = np.abs(input_j).max(initial=0.0)
        return {name: float(value) / KJ for name, value in works.items()}

    def _damping(self, trace: ResponseTrace, forces: Mapping[int, Series]) -> float:
        """Return the work of Rayleigh damping on masses, columns and deck, in J.

        Mean velocities of steps are exact under the trapezoidal rule.
        """
        per_s = 1.0 / np.diff(trace.time_s)
        work = 0.0
        for node in self._damped:
            squared = np.square(np.diff(trace.position(node), axis=0)) @ self._masses[node]
            work += self._mass_factor * float(squared @ per_s)
        for element, stiffness in self._stiffness.items():
            increments = np.diff(self._moved(element, trace), axis=0)
            squared = np.einsum("ij,ij->i", increments @ stiffness, increments)
            work += self._stiffness_factor * float(squared @ per_s)
        for element, force in forces.items():
            work += _work(force, self._moved(element, trace))
        return work

    def _joint_works(self, trace: ResponseTrace, forces: Mapping[int, Series]) -> dict[str, float]:
        """Return the works (J) on pads (``bearings``) and recorded springs of the ``backfill``."""
        works = dict.fromkeys(self._joints, 0.0)
        for name, elements in self._joints.items():
            for element in elements:
                disp = self._moved(element, trace)
                works[name] += _work(forces[element][:, DISP:], disp[:, DISP:] - disp[:, :DISP])
        return works

    def _wall_work(self, trace: ResponseTrace) -> float:
        """Return the work (J) on springs of `held_by_contacts`, from the contact forces on them."""
        contacts = self._model.contacts
        work = 0.0
        for number, unit in enumerate(contacts.units if contacts else ()):
            if unit.node_i not in self._at_walls:
                continue
            components_n = -trace.normals_n[:, number], trace.tangentials_n[:, number]
            force = np.column_stack(components_n) @ np.array((unit.normal, *unit.tangents))
            work += _work(force, trace.position(unit.node_i)[:, :3])
        return work

    def _unbalanced_work(self, trace: ResponseTrace, accelerations: Mapping[int, Series]) -> float:
        """Return the work of the unbalanced forces (input - damping - restoring forces), in J.

        HHT satisfies equilibrium within a step, M a_n+1 = alpha G_n+1 + (1 - alpha) G_n; other
        methods satisfy M a = G at its end.

        References:
            Hilber, Hughes and Taylor (1977), Earthquake Engineering and Structural Dynamics 5.
        """
        mass = np.concatenate(list(self._masses.values()))
        force = np.hstack([accelerations[node] for node in self._masses]) * mass
        if self._integrator[0] == "HHT":
            alpha = float(self._integrator[1])
            for last_row, row in pairwise(force):
                row -= (1.0 - alpha) * last_row
                row /= alpha
        return _work(force, np.hstack([trace.position(node) for node in self._masses]))

    def _moved(self, element: int, trace: ResponseTrace) -> Series:
        return np.hstack([trace.position(node) for node in self._nodes[element]])

    def _end_state(self) -> _EndState:
        kinetic = sum(
            0.5 * float(np.dot(mass, np.square(ops.nodeVel(node))))
            for node, mass in self._masses.items()
        )
        # the dead load of deck and caps acts at nodes; its fixed-end moments work on rotations
        gravity, moments_nm = 0.0, self._model.frame.loads.moments_nm
        for node, load_n in self._model.frame.loads.forces_n.items():
            disp = ops.nodeDisp(node)
            about_x_nm, about_y_nm = moments_nm.get(node, (0.0, 0.0))
            gravity += about_x_nm * disp[3] + about_y_nm * disp[4] - load_n * disp[2]
        elastic = {
            element: (
                np.array(ops.eleForce(element)),
                np.hstack([ops.nodeDisp(node) for node in ops.eleNodes(element)]),
            )
            for elements in self._elastic.values()
            for element in elements
        }
        return _EndState(kinetic, gravity, elastic)

    def _elastic_work(self, group: str, end: _EndState) -> float:
        """Return the work on a group of linear elements (J), from their first and last states."""
        work = 0.0
        for element in self._elastic[group]:
            states = zip(self._start.elastic[element], end.elastic[element], strict=True)
            work += _work(*(np.array(pair) for pair in states))
        return work

    def _contact_works(self) -> tuple[float, float, float]:
        """Return in J: contact work, slip work, and normal work minus stored normal energy."""
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


def energy_ratios(terms: Mapping[str, float]) -> dict[str, float]:
    """Return the energy columns of the demands table, as ratios to the largest input.

    Residual, dissipation by the integrator, and work on normal springs of contacts minus their
    energy (negative: generated). All are nan without a balance or input.
    """
    columns = {
        "energy_residual_ratio": "residual",
        "numerical_dissipation_ratio": "numerical",
        "contact_energy_ratio": "contact_quadrature",
    }
    largest = terms["largest_input"] if terms else 0.0
    return {
        column: terms[name] / largest if largest > 0.0 else float("nan")
        for column, name in columns.items()
    }


def _steps(force: Series, displacement: Series) -> Series:
    """Return the work (J) in each step of force components (n, k), shape (n - 1,)."""
    return 0.5 * np.einsum("ij,ij->i", force[1:] + force[:-1], np.diff(displacement, axis=0))


def _work(force: Series, disp: Series) -> float:
    return float(_steps(force, disp).sum())


def elastic_stiffness(element: int) -> Series:
    """Return the global stiffness of an elastic beam-column in N, m and rad, shape (12, 12).

    Basic deformations: axial, two end rotations about z, two about y, twist.
    """
    start_m, end_m = (np.array(ops.nodeCoord(node)) for node in ops.eleNodes(element))
    length = float(np.linalg.norm(end_m - start_m))
    x, y, z = (np.array(ops.eleResponse(element, f"{axis}axis")) for axis in "xyz")
    zeros, y_per_m, z_per_m = np.zeros(3), y / length, z / length
    basic = np.array(
        [
            np.concatenate((-x, zeros, x, zeros)),
            np.concatenate((y_per_m, z, -y_per_m, zeros)),
            np.concatenate((y_per_m, zeros, -y_per_m, z)),
            np.concatenate((-z_per_m, y, z_per_m, zeros)),
            np.concatenate((-z_per_m, zeros, z_per_m, y)),
            np.concatenate((zeros, -x, zeros, x)),
        ]
    )
    return basic.T @ np.reshape(ops.eleResponse(element, "basicStiffness"), (6, 6)) @ basic


def held_by_contacts(model: BridgeModel) -> dict[int, tuple[int, ...]]:
    """Return, by contact node, the springs to the ground that carry only the contact force.

    Contact nodes with a mass, or with other elements at or behind them, are omitted.
    """
    at_node: dict[int, list[int]] = {}
    for element in ops.getEleTags():
        for node in ops.eleNodes(element):
            at_node.setdefault(node, []).append(element)
    springs, contacts = (set(model.energy_elements[name]) for name in ("backfill", "contact"))
    springs_of_node: dict[int, tuple[int, ...]] = {}
    for contact_node in {unit.node_i for unit in model.contacts.units} if model.contacts else ():
        chain, reached = dict[int, None](), [contact_node]
        for node in reached:
            behind = [tag for tag in at_node[node] if tag not in chain and tag not in contacts]
            chain.update(dict.fromkeys(behind))
            nodes = {node_2 for element in behind for node_2 in ops.eleNodes(element)} - {*reached}
            reached += [node_2 for node_2 in nodes if len(ops.getFixedDOFs(node_2)) < DISP]
        is_free = not any(mass for node in reached for mass in ops.nodeMass(node))
        if is_free and springs.issuperset(chain):
            springs_of_node[contact_node] = tuple(chain)
    return springs_of_node
