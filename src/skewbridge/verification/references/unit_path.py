"""A contact unit driven along a path of displacements, in OpenSees and by the law itself.

Also `skewbridge contact`: a case file in, the forces along its path out.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactLaw, ContactSet, Coupling, Scheme, UnitLedger
from skewbridge.contact.law import advance_pair
from skewbridge.errors import SolutionError
from skewbridge.provenance.files import writable_file
from skewbridge.verification.references.case_files import ContactCase, beside, read_case, read_path
from skewbridge.verification.references.live_model import Array, Solver, clean_domain, path_series

# Part of the first step of a path that is made first.
_START_SHARE: Final = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class PathResult:
    """Forces along a path.

    Attributes:
        forces_n: Shape (rows, 3): tangential forces with the sign of slip, compression positive.
        ledger: Account of the unit; None for the law itself.
    """

    forces_n: Array
    ledger: UnitLedger | None


def drive_unit(
    law: ContactLaw,
    path: Array,
    *,
    substeps: int = 10,
    scheme: Scheme = "vector",
    coupling: Coupling = "extrapolated",
) -> PathResult:
    """Drive one unit of a live model along a path.

    Args:
        law: Parameters of the pair.
        path: Shape (rows, 4): time, two tangential displacements, normal displacement (positive
            opens). Linear between rows. The first row is the state at rest: nothing has slipped.
        substeps: Steps per row.
        scheme: Of the `ContactSet`.
        coupling: Of the `ContactSet`.

    Raises:
        SolutionError: OpenSees does not make a step.
    """
    forces = np.zeros((len(path), 3))
    with clean_domain():
        contacts = _unit_model(law, path, scheme, coupling)
        # To the first row without friction; then take it over as the state of rest.
        _analyze_to_next_row(1)
        contacts.start_from_rest()
        forces[0] = (0.0, 0.0, contacts.normals_n[0])
        dt_s = 0.0
        for row, row_dt in enumerate(np.diff(path[:, 0]).tolist(), start=1):
            for share in _shares(substeps, is_first=row == 1):
                next_dt = share * row_dt
                if next_dt != dt_s:
                    contacts.prepare(next_dt)
                    ops.integrator("LoadControl", share)
                    dt_s = next_dt
                _analyze_to_next_row(row)
                contacts.after_step(dt_s)
            forces[row] = (*contacts.tangentials_n[0], contacts.normals_n[0])
        return PathResult(forces_n=forces, ledger=contacts.ledger()[0])


def follow_law(law: ContactLaw, path: Array, *, substeps: int = 1) -> PathResult:
    """Follow the same path by radial return at the end of each (sub)step: the reference."""
    forces = np.zeros((len(path), 3))
    stick = (float(path[0, 1]), float(path[0, 2]))
    forces[0, 2] = law.kn_n_per_m * max(0.0, -law.open_gap_m - float(path[0, 3]))
    for row, ((x0, y0, z0), (x1, y1, z1)) in enumerate(pairwise(path[:, 1:].tolist()), start=1):
        for step in range(1, substeps + 1):
            share = step / substeps
            position = (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
            state = advance_pair(law, stick, position, law.open_gap_m + z0 + share * (z1 - z0))
            stick = (state.stick_1_m, state.stick_2_m)
            forces[row] = (state.force_1_n, state.force_2_n, state.normal_n)
    return PathResult(forces_n=forces, ledger=None)


def path_work_j(path: Array, forces_n: Array) -> float:
    """Return the work of the friction force along a path, trapezoidal rule over the rows."""
    moved = np.diff(path[:, 1:3], axis=0)
    return float(np.sum(0.5 * (forces_n[1:, :2] + forces_n[:-1, :2]) * moved))


def _unit_model(law: ContactLaw, path: Array, scheme: Scheme, coupling: Coupling) -> ContactSet:
    """Build a pair of nodes, the second one driven; pseudo-time counts the rows from one."""
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    surface, body, anchor, idle = 1, 2, 3, 4
    for node in (surface, body, anchor, idle):
        ops.node(node, 0.0, 0.0, 0.0)
        if node != body:
            ops.fix(node, 0 if node == idle else 1, 1, 1)
    # The solver needs one equation; the idle spring has no load.
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, anchor, idle, "-mat", 1, "-dir", 1)
    contacts = ContactSet(scheme=scheme, coupling=coupling)
    contacts.add(
        surface,
        body,
        (0.0, 0.0, 1.0),
        law.gap_m,
        law.friction,
        law.cohesion_n,
        kn=law.kn_n_per_m,
        kt=law.kt_n_per_m,
        tangent=(1.0, 0.0, 0.0),
        gap_closing_m=law.gap_closing_m,
        name="driven unit",
    )
    drive_node(body, path, system="ProfileSPD")
    return contacts


def drive_node(node: int, path: Array, *, system: str) -> None:
    """Prescribe the displacements of a node; pseudo-time counts the rows of the path from one."""
    for dof in (1, 2, 3):
        path_series(dof, 1.0, np.append(0.0, path[:, dof]))
        ops.pattern("Plain", dof, dof)
        ops.sp(node, dof, 1.0)
    Solver(
        system=system,
        iterations=10,
        algorithm="Linear",
        integrator=("LoadControl", 1.0),
        analysis="Static",
    ).prepare()


def _shares(substeps: int, *, is_first: bool) -> list[float]:
    """Return the parts of a row that are made one by one.

    Before something has moved the direction of slip is unknown, so the first row is made in at
    least ten parts, of which the first is tiny.
    """
    if not is_first:
        return [1.0 / substeps] * substeps
    count = max(10, substeps)
    return [_START_SHARE / count, (1.0 - _START_SHARE) / count, *[1.0 / count] * (count - 1)]


def _analyze_to_next_row(row: int) -> None:
    if ops.analyze(1) != 0:
        raise SolutionError(f"OpenSees did not make the step to row {row} of the path")


def run_contact_case(case_file: Path, out: Path) -> dict[str, float | int | str]:
    """Run a contact case, write its forces, and return their peaks, work and cone violation.

    The CSV has t_s, fx_n, fy_n, fz_n at the times of the path: forces with the sign of slip,
    compression positive.

    Raises:
        InputError: The case, the path or the output folder is wrong.
        SolutionError: OpenSees does not make a step.
    """
    case = read_case(case_file, ContactCase)
    path = read_path(beside(case_file, case.path))
    writable_file(out)
    options = case.model_dump(include={"substeps", "scheme", "coupling"})
    law = ContactLaw(
        kn_n_per_m=case.normal_stiffness_n_per_m,
        kt_n_per_m=case.tangent_stiffness_n_per_m,
        **case.model_dump(include={"friction", "cohesion_n", "gap_m"}),
    )
    result = drive_unit(law, path, **options)
    table = pd.DataFrame(result.forces_n, columns=["fx_n", "fy_n", "fz_n"])
    table.insert(0, "t_s", path[:, 0])
    table.to_csv(out, index=False)
    summary: dict[str, float | int | str] = {
        "rows": len(path),
        "peak_friction_n": float(np.hypot(*result.forces_n[:, :2].T).max()),
        "peak_normal_n": float(result.forces_n[:, 2].max()),
        "friction_work_j": path_work_j(path, result.forces_n),
    }
    if result.ledger is not None:
        summary |= {
            "closures": result.ledger.closures,
            "slip_work_j": result.ledger.slip_work_j,
            "cone_violation_n": result.ledger.cone_violation_n,
            "cone_violation_ratio": result.ledger.cone_violation_ratio,
        }
    return summary | {"out": str(out)}
