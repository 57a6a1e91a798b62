"""`skewbridge contact`: a case file in, the forces along its path out."""

from pathlib import Path

import numpy as np
import pandas as pd

from skewbridge.contact import ContactLaw
from skewbridge.provenance.files import writable_file
from skewbridge.verification.references.case_files import ContactCase, beside, read_case, read_path
from skewbridge.verification.references.unit_path import drive_unit, path_work_j


def run_contact_case(case_file: Path, out: Path) -> dict[str, float | int | str]:
    """Run a contact case and write its forces.

    Args:
        case_file: YAML with the fields of `ContactCase`; `path` is beside it, or from the working
            folder.
        out: CSV to write: t_s, fx_n, fy_n, fz_n at the times of the path; forces with the sign
            of slip, compression positive.

    Returns:
        Peaks, work and cone violation of the run.

    Raises:
        InputError: The case, the path or the output folder is wrong.
        SolutionError: OpenSees does not make a step.
    """
    case = read_case(case_file, ContactCase)
    path = read_path(beside(case_file, case.path))
    writable_file(out)
    law = ContactLaw(
        kn_n_per_m=case.normal_stiffness_n_per_m,
        kt_n_per_m=case.tangent_stiffness_n_per_m,
        friction=case.friction,
        cohesion_n=case.cohesion_n,
        gap_m=case.gap_m,
    )
    result = drive_unit(
        law, path, substeps=case.substeps, scheme=case.scheme, coupling=case.coupling
    )
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
