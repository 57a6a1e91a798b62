"""The plain reading of the paper: our physics, with the numerics of an ordinary script.

The model is that of the package (same variant, wall model, pads, backfill, keys, column
integration, capacities). What is plain: corotational arrays, 204 fibers a section, UmfPack, Newton,
a test on the norm of displacements, Houbolt at the paper's step, friction bounds from the last
committed state, and element responses of all contacts read in every step. `speedup.py` runs it.
"""

import time
from array import array
from dataclasses import dataclass, field, replace
from math import hypot
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops
from common import Case

from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.analysis.settings import PAPER_DT_S, AnalysisSettings
from skewbridge.analysis.step_loop import solver_log
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions

# Stated in full, so that the plain model stays the same when the defaults change.
PLAIN_OPTIONS: Final[dict[str, Any]] = {
    "arrays": "corotational",
    "coupling": "lagged",
    "pads": "each",  # a bearing element of OpenSees each
    "column_fibers": (10, 21, 2),  # with the bars 204 fibers
    "backwall_points": 5,
    "deck_elements_per_span": 4,
}
INTEGRATOR: Final = "Houbolt"
TEST: Final = ("NormDispIncr", 1.0e-8, 30)
# Attempts at a step where Newton fails, in turn: algorithm and number of equal parts.
FALLBACKS: Final = (("NewtonLineSearch", 1), ("NewtonLineSearch", 4), ("KrylovNewton", 20))


@dataclass(slots=True, kw_only=True)
class PlainRun:
    """Result of a plain analysis.

    Attributes:
        status: ``ok``, ``collapse``, or ``failed`` where all fallbacks failed.
        failed_steps: Steps where Newton failed.
        steps: Steps taken.
        iterations: Iterations of the converged regular steps.
    """

    status: str = "ok"
    failed_steps: int = 0
    steps: int = 0
    iterations: int = 0
    time_reached_s: float = 0.0
    cpu_s: float = 0.0
    demands: dict[str, float] = field(default_factory=dict)


def plain_options(options: ModelOptions) -> ModelOptions:
    """Return the options of the plain model: the physics of ours, its own discretisation."""
    return replace(options, **PLAIN_OPTIONS)


def analyse_plain(case: Case, settings: AnalysisSettings, options: ModelOptions) -> PlainRun:
    """Analyse a case from an empty domain; the processor time is that of everything."""
    settings = replace(settings, dt_s=PAPER_DT_S, contact_dt_s=None, event_dt_s=None)
    start_s = time.process_time()
    ground = GroundInput(Excitation(motion=case.motion), settings)
    with solver_log(None), domain():
        model = build(case.variant, plain_options(options))
        apply_rayleigh(model)
        ground.apply(model.tags)
        run = _PlainHistory(model, settings).run(ground.steps)
    run.cpu_s = time.process_time() - start_s
    return run


class _PlainHistory:
    """Step loop of an ordinary script, with its recorders."""

    def __init__(self, model: BridgeModel, settings: AnalysisSettings) -> None:
        self._model, self._settings = model, settings
        self._contacts = model.contacts
        units = () if model.contacts is None else model.contacts.units
        self._contact_elements = [unit.element for unit in units]
        corners = [corner.node for end in model.abutments for corner in end.corners]
        walls = [node for end in model.abutments for node in end.wall_nodes]
        ends = [node for column in model.columns for node in (column.top_node, column.base_node)]
        self._nodes = tuple(dict.fromkeys((model.deck_centre_node, *ends, *corners, *walls)))
        self._columns = tuple(column.element for column in model.columns)
        self._at = {node: 6 * number for number, node in enumerate(self._nodes)}
        self._width = 6 * len(self._nodes) + 12 * len(self._columns)
        self._rows = self._rest = array("d")
        self._run = PlainRun()

    def run(self, steps: int) -> PlainRun:
        """Take the steps."""
        if self._contacts is not None:
            self._contacts.start_from_rest()
        ops.wipeAnalysis()
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test(*TEST)
        ops.algorithm("Newton")
        ops.integrator(INTEGRATOR)
        ops.analysis("Transient", "-noWarnings")
        self._read()
        self._rest = self._rows[:]
        run, dt_s = self._run, self._settings.dt_s
        for _ in range(steps):
            if ops.analyze(1, dt_s) == 0:
                run.iterations += ops.testIter()
                self._after(dt_s)
            elif not self._fall_back(dt_s):
                run.status = "failed"
                break
            run.steps += 1
            if self._has_collapsed():
                run.status = "collapse"
                break
        run.time_reached_s = float(ops.getTime())
        run.demands = self._demands()
        return run

    def _fall_back(self, dt_s: float) -> bool:
        """Retry a failed step; Houbolt and the equations are reset before each attempt."""
        self._run.failed_steps += 1
        left = finest = FALLBACKS[-1][1]
        for algorithm, parts in FALLBACKS:
            ops.algorithm(algorithm)
            ops.integrator(INTEGRATOR)
            ops.domainChange()
            share = finest // parts
            while left >= share and ops.analyze(1, dt_s / parts) == 0:
                left -= share
                self._after(dt_s / parts)
            if left == 0:
                break
        ops.algorithm("Newton")
        ops.integrator(INTEGRATOR)
        ops.domainChange()
        return left == 0

    def _after(self, dt_s: float) -> None:
        for element in self._contact_elements:
            ops.eleResponse(element, "force")
            ops.eleResponse(element, "deformation")
        if self._contacts is not None:
            self._contacts.after_step(dt_s)
        self._read()

    def _read(self) -> None:
        for node in self._nodes:
            self._rows.extend(ops.nodeDisp(node))
        for element in self._columns:
            self._rows.extend(ops.eleResponse(element, "force"))

    def _has_collapsed(self) -> bool:
        """Whether the deck or a column is beyond the limits of the analysis."""
        now, limits = self._rows[-self._width :], self._settings
        rest, model, at = self._rest, self._model, self._at

        def moved(node: int) -> tuple[float, float]:
            place = at[node]
            return now[place] - rest[place], now[place + 1] - rest[place + 1]

        for column in model.columns:
            top, base = moved(column.top_node), moved(column.base_node)
            drift = hypot(top[0] - base[0], top[1] - base[1]) / column.clear_height_m
            if not drift < limits.collapse_drift_ratio:
                return True
        for end in model.abutments:
            for corner in end.corners:
                x, y = moved(corner.node)
                if -(x * end.normal[0] + y * end.normal[1]) > end.support_length_m:
                    return True
        return hypot(*moved(model.deck_centre_node)) > limits.collapse_deck_disp_m

    def _demands(self) -> dict[str, float]:
        """Return the peaks, by the definitions of the demands table."""
        rows = np.array(self._rows).reshape(-1, self._width)
        places = {node: rows[:, 6 * at : 6 * at + 6] for at, node in enumerate(self._nodes)}
        moves = {node: place - place[0] for node, place in places.items()}
        model, forces = self._model, rows[:, 6 * len(self._nodes) :]
        shears, drifts = [0.0], [0.0]
        for number, column in enumerate(model.columns):
            top, base = column.top_node, column.base_node
            force = forces[:, 12 * number : 12 * number + 3]
            chord = (places[top] - places[base])[:, :2] / column.clear_height_m
            shear = force[:, :2] - force[:, 2:] * chord
            drift = (moves[top] - moves[base])[:, :2] / column.clear_height_m
            shears.append(float(np.hypot(*shear.T).max()) / KN)
            drifts.append(float(np.hypot(*drift.T).max()))
        deck = moves[model.deck_centre_node]
        away, pushes = [0.0], [0.0]
        for end in model.abutments:
            normal = np.array(end.normal)
            away += [float((-moves[c.node][:, :2] @ normal).max()) for c in end.corners]
            pushes += [float((moves[node][:, :2] @ normal).max()) for node in end.wall_nodes]
        return {
            "column_shear_kn": max(shears),
            "column_drift_ratio": max(drifts),
            "deck_disp_m": float(np.hypot(deck[:, 0], deck[:, 1]).max()),
            "unseating_m": max(away),
            "deck_rotation_rad": float(np.abs(deck[:, 5]).max()),
            "abutment_passive_m": max(pushes),
        }
