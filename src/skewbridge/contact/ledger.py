"""What a contact did over a run: closures, extremes, work, and how far the cone was left."""

from dataclasses import asdict, dataclass


@dataclass(slots=True)
class Account:
    """Running sums of one contact unit; plain numbers, added up in the step loop.

    Attributes:
        closures: Number of steps that ended closed after one that ended open.
        contact_time_s: Time spent closed.
        max_penetration_m: Largest negative opening.
        max_normal_n: Largest compression.
        max_friction_n: Largest tangential force.
        max_limit_n: Largest friction limit.
        max_violation_n: Largest excess of the tangential force over cohesion + friction x normal
            force at the end of a step.
        slip_path_m: Length of the way slipped in contact.
        slip_work_j: Energy dissipated by slip, trapezoidal rule on end-of-step forces.
        normal_work_j: Work done on the normal spring (and its dashpot), the same rule.
        friction_impulse_ns: Sum of friction force times step.
        friction_work_j: Sum of end-of-step friction force times slip: what the shares below are of.
        excess_work_j: The part of it above the limit at the end of the step.
        opening_work_j: The part of it in steps in which the pair opened.
        time_over_1_s: Time with a friction force 1 % above its limit and more; ``_10``, ``_50`` so.
        work_over_1_j: Friction work in that time.
    """

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
    friction_impulse_ns: float = 0.0
    friction_work_j: float = 0.0
    excess_work_j: float = 0.0
    opening_work_j: float = 0.0
    time_over_1_s: float = 0.0
    time_over_10_s: float = 0.0
    time_over_50_s: float = 0.0
    work_over_1_j: float = 0.0
    work_over_10_j: float = 0.0
    work_over_50_j: float = 0.0


@dataclass(slots=True, kw_only=True)
class UnitLedger(Account):
    """Ledger of one contact unit since it was added.

    Attributes:
        name: Name given by the caller.
        normal_potential_j: Energy stored in the normal spring at the end.
    """

    name: str
    normal_potential_j: float

    @property
    def cone_violation_n(self) -> float:
        """Largest excess; at most friction x (error of the predicted normal force)."""
        return self.max_violation_n

    @property
    def cone_violation_ratio(self) -> float:
        """Largest excess over the largest friction limit of the run."""
        return self.max_violation_n / self.max_limit_n if self.max_limit_n > 0.0 else 0.0


def close_account(name: str, account: Account, normal_potential_j: float) -> UnitLedger:
    """Return the ledger of a unit from its running sums."""
    return UnitLedger(name=name, normal_potential_j=normal_potential_j, **asdict(account))
