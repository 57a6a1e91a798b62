"""Response history of one abutment with its share of the deck mass, as in the paper."""

from dataclasses import dataclass

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import Ending, StepLoop, solver_log
from skewbridge.analysis.trace import Series, at_regular_steps
from skewbridge.bridge.model import AbutmentModel, build_abutment, domain
from skewbridge.contact.law import UnitLedger
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

MAX_DISP_M = 5.0  # larger than any seat width: the abutment model is no longer valid


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHistory:
    """Response of an abutment at n regular times."""

    t_s: Series
    disp_m: Series  # displacement of the deck end along x and y since dead load, shape (n, 2)
    force_n: Series  # force on the deck, positive if it opposes positive displacement, shape (n, 2)
    normals_n: Series  # normal forces of the contact units, shape (n, units)
    friction_n: Series  # resultant friction forces of the contact units, shape (n, units)
    unit_names: tuple[str, ...]
    ledger: tuple[UnitLedger, ...]
    is_complete: bool  # whether the analysis reached its end
    failures: int  # how often a recovery step did not converge


def abutment_history(
    variant: Variant, excitation: Excitation, settings: AnalysisSettings, options: ModelOptions
) -> AbutmentHistory:
    """Analyse the right abutment of a variant with its share of the deck mass.

    The deck end does not rotate; +x pushes into the backfill. Only dashpots, pads and soil damp.
    """
    ground = GroundInput(excitation, settings)
    rows: list[list[float]] = []
    with solver_log(None), domain():
        abutment = build_abutment(variant, settings.model_options(options))
        ground.apply(abutment.blueprint.tags)
        contacts = abutment.blueprint.contacts

        def read() -> Ending | None:
            moved_m = ops.nodeDisp(abutment.connector)[:2]
            row = [float(ops.getTime()), *moved_m, *_resisting_force_n(abutment)]
            if contacts is not None:
                row += contacts.normals_n
                row += [float(np.hypot(*pair)) for pair in contacts.tangentials_n]
            rows.append(row)
            if abs(moved_m[0]) < MAX_DISP_M:
                return None
            message = f"the deck end moved {MAX_DISP_M:g} m"
            return Ending(status="numerical_failure", message=message)

        loop = StepLoop(contacts, settings, longest_s=0.0)
        read()
        ending = loop.run(ground.steps, read)
    units = contacts.units if contacts else ()
    table = np.array(rows)
    table = table[at_regular_steps(table[:, 0], settings.dt_s)]
    return AbutmentHistory(
        t_s=table[:, 0],
        disp_m=table[:, 1:3] - table[0, 1:3],
        force_n=table[:, 3:5],
        normals_n=table[:, 5 : 5 + len(units)],
        friction_n=table[:, 5 + len(units) :],
        unit_names=tuple(unit.name for unit in units),
        ledger=tuple(contacts.ledger()) if contacts else (),
        is_complete=ending.status == "ok",
        failures=loop.effort.failures,
    )


def _resisting_force_n(abutment: AbutmentModel) -> list[float]:
    """Return the force on the deck along x and y (N), positive if it opposes displacement."""
    handle, contacts = abutment.handle, abutment.blueprint.contacts
    total = np.zeros(2)
    for bearing in handle.bearings:
        total += ops.eleForce(bearing.element)[6:8]
    if contacts is not None:
        for unit in (*handle.wall_units, *handle.key_units):
            total -= contacts.global_force_on_j(unit)[:2]
    else:
        for spring in handle.springs:
            force = ops.basicForce(spring.element)[spring.component]
            total += np.multiply(force, spring.direction)
    return total.tolist()
