"""A contact unit driven along a displacement path, in OpenSees and with only the contact law.

A path has the columns t_s, ux_m, uy_m, uz_m (positive opens) and is linear between its rows.
`skewbridge contact` runs a unit from a case file.
"""

from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import openseespy.opensees as ops
import pandas as pd

from skewbridge.contact import ContactLaw, ContactSet, Coupling, Scheme, UnitLedger
from skewbridge.contact.law import advance_pair
from skewbridge.errors import SolutionError
from skewbridge.files.tables import Floats
from skewbridge.files.text import writable_file
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.cases import ContactCase, file_of_case, read_case, read_path

# Law of figure 3. ASSUME Kn = Kt = 1e5 N/m: the paper gives friction and cohesion only.
PAPER_LAW: Final = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3, cohesion_n=1500.0)
# Fraction of the first sub-step of a path that is taken as a separate tiny step.
_START_SHARE: Final = 1e-3
_SURFACE, _BODY, _ANCHOR, _UNLOADED = 1, 2, 3, 4  # nodes


class PathResult(NamedTuple):
    """Forces along a path, shape (rows, 3), and the energy ledger of the unit.

    The columns are the two tangential forces with the sign of slip, and the compression.
    """

    forces_n: Floats
    ledger: UnitLedger


def drive_unit(
    law: ContactLaw,
    path: Floats,
    *,
    substeps: int = 10,
    scheme: Scheme = "vector",
    coupling: Coupling = "extrapolated",
) -> PathResult:
    """Drive a contact unit in OpenSees along a path, with `substeps` steps between rows.

    The first row of the path, shape (rows, 4), is the state at rest, before any slip.
    """
    forces, contacts = np.zeros((len(path), 3)), ContactSet(scheme=scheme, coupling=coupling)
    with live.clean_domain(3, 3):
        _support_nodes()
        contact = _SURFACE, _BODY, (0.0, 0.0, 1.0), law.gap_m, law.friction, law.cohesion_n
        penalties: Any = {"kn": law.kn_n_per_m, "kt": law.kt_n_per_m}
        contacts.add(*contact, **penalties, tangent=(1.0, 0.0, 0.0))
        _drive_body(path)
        # Go to the first row without friction; it becomes the state at rest.
        _analyze_to_next_row(1)
        contacts.start_from_rest()
        forces[0] = (0.0, 0.0, contacts.normals_n[0])
        dt_s = 0.0
        for row, row_dt in enumerate(np.diff(path[:, 0]).tolist(), start=1):
            # Before any motion the direction of slip is unknown, so the first interval takes at
            # least ten steps, the first of them tiny.
            n_steps = substeps if row > 1 else max(10, substeps)
            fractions = [1.0 / n_steps] * n_steps
            if row == 1:
                fractions[:1] = [_START_SHARE / n_steps, (1.0 - _START_SHARE) / n_steps]
            for fraction in fractions:
                next_dt = fraction * row_dt
                if next_dt != dt_s:
                    contacts.prepare(next_dt)
                    ops.integrator("LoadControl", fraction)
                    dt_s = next_dt
                _analyze_to_next_row(row)
                contacts.after_step(dt_s)
            forces[row] = (*contacts.tangentials_n[0], contacts.normals_n[0])
        return PathResult(forces, contacts.ledger()[0])


def follow_law(law: ContactLaw, path: Floats, *, substeps: int = 1) -> Floats:
    """Return the reference forces (N), shape (rows, 3), by radial return in every sub-step."""
    forces = np.zeros((len(path), 3))
    stick = (float(path[0, 1]), float(path[0, 2]))
    forces[0, 2] = law.kn_n_per_m * max(0.0, -law.gap_m - float(path[0, 3]))
    for row, ((x0, y0, z0), (x1, y1, z1)) in enumerate(pairwise(path[:, 1:].tolist()), start=1):
        for step in range(1, substeps + 1):
            fraction = step / substeps
            position = (x0 + fraction * (x1 - x0), y0 + fraction * (y1 - y0))
            state = advance_pair(law, stick, position, law.gap_m + z0 + fraction * (z1 - z0))
            stick, forces[row] = state.stick_m, (*state.force_n, state.normal_n)
    return forces


def path_work_j(path: Floats, forces_n: Floats) -> float:
    """Return the work (J) of the friction force along a path, by the trapezoidal rule."""
    steps_m = np.diff(path[:, 1:3], axis=0)
    return float(np.sum(0.5 * (forces_n[1:, :2] + forces_n[:-1, :2]) * steps_m))


def _support_nodes() -> None:
    for node in (_SURFACE, _BODY, _ANCHOR, _UNLOADED):
        ops.node(node, 0.0, 0.0, 0.0)
    for node, along_x in ((_SURFACE, 1), (_ANCHOR, 1), (_UNLOADED, 0)):
        ops.fix(node, along_x, 1, 1)
    # The solver needs at least one equation: a spring without load.
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, _ANCHOR, _UNLOADED, "-mat", 1, "-dir", 1)


def _drive_body(path: Floats) -> None:
    """Prescribe the displacements of the body; the pseudo-time is the row number, from one."""
    for dof in (1, 2, 3):
        live.path_series(dof, 1.0, np.append(0.0, path[:, dof]))
        ops.pattern("Plain", dof, dof)
        ops.sp(_BODY, dof, 1.0)
    static: Any = {"integrator": ("LoadControl", 1.0), "analysis": "Static"}
    live.prepare_analysis(system="ProfileSPD", algorithm="Linear", **static)


def _analyze_to_next_row(row: int) -> None:
    if ops.analyze(1) != 0:
        raise SolutionError(f"OpenSees did not converge in the step to row {row} of the path")


def run_contact_case(case_file: Path, out: Path) -> dict[str, float | int | str]:
    """Run a contact case, write its forces as CSV; return peaks, work and cone violation."""
    case = read_case(case_file, ContactCase)
    path = read_path(file_of_case(case_file, case.path))
    writable_file(out)
    kn, kt = case.normal_stiffness_n_per_m, case.tangent_stiffness_n_per_m
    limits = case.model_dump(include={"friction", "cohesion_n", "gap_m"})
    options = case.model_dump(include={"substeps", "scheme", "coupling"})
    forces_n, ledger = drive_unit(ContactLaw(kn, kt, **limits), path, **options)
    table = pd.DataFrame(forces_n, columns=["fx_n", "fy_n", "fz_n"])
    table.insert(0, "t_s", path[:, 0])
    table.to_csv(out, index=False)
    return {
        "rows": len(path),
        "peak_friction_n": float(np.hypot(*forces_n[:, :2].T).max()),
        "peak_normal_n": float(forces_n[:, 2].max()),
        # slip and the energy of the spring: forces vary between the rows of a path
        "friction_work_j": ledger.slip_work_j + float(np.sum(forces_n[-1, :2] ** 2)) / (2.0 * kt),
        "closures": ledger.closures,
        "slip_work_j": ledger.slip_work_j,
        "cone_violation_n": ledger.max_violation_n,
        "cone_violation_ratio": ledger.cone_violation_ratio,
        "out": str(out),
    }


def circle(radius_m: float, rows_per_loop: int) -> Floats:
    """Return a circular path through the origin: two loops of 4 s, 0.1 m into the surface."""
    t = np.linspace(0.0, 8.0, 2 * rows_per_loop + 1)
    x, y = radius_m * np.sin(0.5 * pi * t), radius_m * (1.0 - np.cos(0.5 * pi * t))
    return np.column_stack([t, x, y, np.full_like(t, -0.1)])


def triangle(t_s: Floats, period_s: float) -> Floats:
    """Return a triangle wave of amplitude 1 that starts at 0 with a positive slope."""
    phase = np.mod(t_s / period_s + 0.25, 1.0)
    return 1.0 - 4.0 * np.abs(phase - 0.5)


def figure_3(rows_per_s: int) -> Floats:
    """Return the path of Figure 3 of the paper (12 s).

    Triangle waves along x (4 s, 1 m) and y (6 s, 2 m); a square wave along the normal (2.5 s, 0.1
    m).
    """
    # ASSUME all waves start at time zero, triangles rising, contact open: not in the paper.
    t = np.arange(12 * rows_per_s + 1) / rows_per_s
    is_open = np.mod(t, 2.5) < 1.25 - 1e-9
    z = np.where(is_open, 0.1, -0.1)
    return np.column_stack([t, triangle(t, 4.0), 2.0 * triangle(t, 6.0), z])
