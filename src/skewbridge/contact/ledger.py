"""What a contact did over a run: closures, extremes, work, and how far the cone was left."""

from dataclasses import asdict, dataclass


@dataclass(slots=True)
class Account:
    """Running sums of one contact unit; plain numbers, added up in the step loop."""

    closures: int = 0
    contact_time_s: float = 0.0
    max_penetration_m: float = 0.0
    max_normal_n: float = 0.0
    max_friction_n: float = 0.0
    max_limit_n: float = 0.0
    max_violation_n: float = 0.0
    slip_path_m: float = 0.0
    slip_work_j: float = 0.0
    normal_work_j: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitLedger:
    """Ledger of one contact unit since it was added.

    Attributes:
        name: Name given by the caller.
        closures: Number of steps that ended closed after one that ended open.
        contact_time_s: Time spent closed.
        max_penetration_m: Largest negative opening.
        max_normal_n: Largest compression.
        max_friction_n: Largest tangential force.
        slip_path_m: Length of the way slipped in contact.
        slip_work_j: Energy dissipated by slip, trapezoidal rule on end-of-step forces.
        normal_work_j: Work done on the normal spring (and its dashpot), the same rule.
        normal_potential_j: Energy stored in the normal spring at the end.
        cone_violation_n: Largest excess of the tangential force over cohesion + friction x normal
            force at the end of a step; at most friction x (error of the predicted normal force).
        cone_violation_ratio: The same over the largest friction limit of the run.
    """

    name: str
    closures: int
    contact_time_s: float
    max_penetration_m: float
    max_normal_n: float
    max_friction_n: float
    slip_path_m: float
    slip_work_j: float
    normal_work_j: float
    normal_potential_j: float
    cone_violation_n: float
    cone_violation_ratio: float


def close_account(name: str, account: Account, normal_potential_j: float) -> UnitLedger:
    """Return the ledger of a unit from its running sums."""
    sums = asdict(account)
    limit, violation = sums.pop("max_limit_n"), sums.pop("max_violation_n")
    return UnitLedger(
        name=name,
        normal_potential_j=normal_potential_j,
        cone_violation_n=violation,
        cone_violation_ratio=violation / limit if limit > 0.0 else 0.0,
        **sums,
    )
