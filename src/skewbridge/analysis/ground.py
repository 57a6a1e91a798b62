"""Ground input of an analysis: uniform excitation, or a motion of its own for each support.

Supports are `left`, `right` and `bent 1` and so on, from left to right. Their displacements are
imposed on the fixed nodes of the model, so the model moves in fixed axes. `SupportInput.relative`
subtracts from every node the ground of its own support: demands and histories then mean the same
as under uniform input. The support of a node is the one whose skewed line is nearest.

Under support motions damping is proportional to stiffness only: a part that is proportional to mass
would damp the motion of the ground itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import ceil, hypot, isfinite
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.trace import ResponseTrace, Series
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.plan import PlanVector
from skewbridge.bridge.script_units import view_constraints
from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion

MAX_SCALED_ACCEL_MPS2: Final = 1.0e3  # 100 g: a larger value means a wrong unit
#: Points of the imposed displacement per time step of the record or the analysis, if it is shorter.
_POINTS_PER_STEP: Final = 4
#: Time in which the correction of the baseline reaches its slope: so slowly that its acceleration
#: is below 0.5 % g for an initial velocity of 5 cm/s.
_SETTLING_S: Final = 1.0
_IN_PLAN: Final = (1, 2)  # horizontal degrees of freedom


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excitation:
    """Ground motion of an analysis, with its factor and direction.

    At incidence 0, component 1 points along x; incidence is counter-clockwise. `supports` maps
    names of supports to motions along the axes of the bridge (`SupportInput`); `motion` is then
    that of the support nearest to the mass centre. Raises `InputError` if a number is not finite or
    the scale is not positive.
    """

    motion: GroundMotion
    scale: float = 1.0
    incidence_deg: float = 0.0
    supports: Mapping[str, GroundMotion] = field(default_factory=dict[str, GroundMotion])

    def __post_init__(self) -> None:
        if not (isfinite(self.scale) and self.scale > 0.0):
            raise InputError(f"scale must be a positive number, got {self.scale}")
        if not isfinite(self.incidence_deg):
            raise InputError(f"incidence_deg must be a number, got {self.incidence_deg}")
        if self.supports and self.incidence_deg:
            raise InputError("incidence_deg must be 0: support motions are along x and y")


class GroundInput:
    """Ground acceleration of one analysis along the bridge axes, linear between samples.

    `InputError` if it is so large that its unit must be wrong.
    """

    def __init__(self, excitation: Excitation, settings: AnalysisSettings) -> None:
        motion = excitation.motion
        accel = excitation.scale * np.column_stack(motion.along_axes(excitation.incidence_deg))
        largest = float(np.abs(accel).max())
        if not largest <= MAX_SCALED_ACCEL_MPS2:
            raise InputError(
                f"motion {motion.motion_id}: peak acceleration must be at most "
                f"{MAX_SCALED_ACCEL_MPS2:g} m/s2, got {largest:g}: check its unit and factor"
            )
        longest_s = max(m.duration_s for m in (motion, *excitation.supports.values()))
        shaken_s = min(settings.duration_s or longest_s, longest_s)
        self.dt_s, self.scale, self.shaken_s = motion.dt_s, excitation.scale, shaken_s
        self.accel_mps2 = accel[: motion.npts_until(shaken_s)]
        self.steps = ceil((shaken_s + settings.free_vibration_s) / settings.dt_s - 1e-9)
        self.duration_s = self.steps * settings.dt_s
        self._times_s = np.arange(len(self.accel_mps2)) * motion.dt_s

    def apply(self, tags: TagAllocator) -> None:
        """Add uniform excitation along x and y to the domain."""
        # ASSUME abutments and bent move alike: no wave passage, no vertical component
        for direction, values in enumerate(self.accel_mps2.T, start=1):
            series = tags.series()
            ops.timeSeries("Path", series, "-dt", self.dt_s, "-values", *values.tolist())
            ops.pattern("UniformExcitation", tags.pattern(), direction, "-accel", series)

    def at(self, times_s: Series) -> Series:
        """Return the ground acceleration along x and y at given times, shape (n, 2)."""
        return np.column_stack(
            [np.interp(times_s, self._times_s, values, right=0.0) for values in self.accel_mps2.T]
        )


# --- support motions


def displacements_m(accel_mps2: Mapping[str, Series], dt_s: float) -> dict[str, Series]:
    """Return the displacement (m) of each support from rest, shape (n, 2).

    A triggered or filtered record starts with a velocity that its file does not always state, so
    the displacements of two supports would drift apart. Their difference to the mean of all
    supports is therefore corrected by a line, which is entered smoothly from rest. The mean is not
    corrected: it moves the whole model, as in uniform input.
    """
    mean = np.mean(list(accel_mps2.values()), axis=0)
    mean_disp = _integrated(mean, dt_s)
    times = np.arange(len(mean)) * dt_s / _SETTLING_S
    decay = np.exp(-times)
    ramps = np.column_stack([1.0 - decay * (1.0 + times), times - 1.0 + decay])
    # after the start, and weighted so that the phase of a wave at the ends does not tilt the line
    weight = np.zeros((len(mean), 1))
    is_late = times > min(3.0, times[-1] / 2.0)
    weight[is_late, 0] = np.hanning(np.count_nonzero(is_late))

    def corrected(disp: Series) -> Series:
        return disp - ramps @ np.linalg.lstsq(weight * ramps, weight * disp, rcond=None)[0]

    return {
        name: mean_disp + corrected(_integrated(accel - mean, dt_s))
        for name, accel in accel_mps2.items()
    }


def _integrated(accel: Series, dt_s: float) -> Series:
    """Return the displacement (m) of an acceleration (m/s2) that is linear between samples."""
    velocity, disp = np.zeros_like(accel), np.zeros_like(accel)
    velocity[1:] = np.cumsum((accel[1:] + accel[:-1]) * dt_s / 2.0, axis=0)
    steps = velocity[:-1] * dt_s + (2.0 * accel[:-1] + accel[1:]) * dt_s**2 / 6.0
    disp[1:] = np.cumsum(steps, axis=0)
    return disp


#: Normal of the line of a support in plan, and distance (m) of the line from the origin along it.
type SupportLine = tuple[PlanVector, float]


def support_lines(model: BridgeModel) -> dict[str, SupportLine]:
    """Return the line of each support, by name, from left to right."""
    supports = [(end.plan.name, end.plan.middle_m, end.plan.normal) for end in model.frame.ends]
    for number in {column.bent for column in model.columns}:
        columns = [column for column in model.columns if column.bent == number]
        places_m = np.array([ops.nodeCoord(column.base_node)[:2] for column in columns])
        (x, y), normal = places_m.T, columns[0].normal
        if np.ptp(y) > 0.0:  # the columns of a script do not state the skew of their bent
            slope = float(np.polyfit(y, x, 1)[0])
            normal = 1.0 / hypot(1.0, slope), -slope / hypot(1.0, slope)
        supports.append((f"bent {number + 1}", (float(x.mean()), float(y.mean())), normal))
    supports.sort(key=lambda support: support[1])
    return {name: (normal, float(np.dot(middle, normal))) for name, middle, normal in supports}


def support_of(node: int, lines: Mapping[str, SupportLine]) -> str:
    """Return the name of the support whose line is nearest to a node."""
    place_m = ops.nodeCoord(node)[:2]
    return min(lines, key=lambda name: abs(np.dot(place_m, lines[name][0]) - lines[name][1]))


class SupportInput:
    """Displacements imposed on the supports of a model in the open domain.

    Raises:
        InputError: A support of the model has no motion, or a motion has no support.
    """

    def __init__(
        self, motions: Mapping[str, GroundMotion], ground: GroundInput, model: BridgeModel
    ) -> None:
        self._lines = support_lines(model)
        if motions.keys() != self._lines.keys():
            raise InputError(
                f"support motions must be given for the supports {', '.join(self._lines)}, "
                f"got {', '.join(motions)}"
            )
        self._ground = ground
        step_s = ground.dt_s / _POINTS_PER_STEP
        times = np.arange(0.0, ground.duration_s + step_s / 2, step_s)
        self._step_s = step_s
        is_shaken = times[:, None] <= ground.shaken_s + step_s / 2  # then at constant velocity

        def accel_mps2(motion: GroundMotion) -> Series:
            record_s = np.arange(motion.npts) * motion.dt_s
            along = [np.interp(times, record_s, values, right=0.0) for values in motion.components]
            return ground.scale * np.column_stack(along) * is_shaken

        accel = {name: accel_mps2(motion) for name, motion in motions.items()}
        self._disp = displacements_m(accel, step_s)

    def apply(self, model: BridgeModel) -> None:
        """Impose the displacement of its support on every node that is fixed in plan."""
        tags, motion_tags = model.tags, dict[tuple[str, int], int]()
        view_constraints()  # with plain constraints, only velocities are imposed
        ops.pattern("MultipleSupport", tags.pattern())
        for name, disp in self._disp.items():
            velocity = np.gradient(disp, self._step_s, axis=0)
            for dof, component in enumerate(disp.T, start=1):
                series = [tags.series() for _ in range(3)]
                accel = np.gradient(velocity[:, dof - 1], self._step_s)
                values = (component, velocity[:, dof - 1], accel)
                for tag, samples, flag in zip(series, values, (("-useLast",), (), ()), strict=True):
                    path = ("-dt", self._step_s, "-values", *samples.tolist())
                    ops.timeSeries("Path", tag, *path, *flag)
                motion_tags[name, dof] = len(motion_tags) + 1
                kinds = ("-disp", series[0], "-vel", series[1], "-accel", series[2])
                ops.groundMotion(motion_tags[name, dof], "Plain", *kinds)
        for node in ops.getNodeTags():
            if set(_IN_PLAN) <= set(ops.getFixedDOFs(node)):
                for dof in _IN_PLAN:
                    ops.imposedMotion(node, dof, motion_tags[support_of(node, self._lines), dof])

    def relative(self, trace: ResponseTrace) -> ResponseTrace:
        """Return a trace with displacements relative to the ground of the support of each node."""
        steps = trace.time_s / self._step_s
        ground_m = {
            name: np.column_stack([np.interp(steps, np.arange(len(u_m)), u_m) for u_m in disp.T])
            for name, disp in self._disp.items()
        }
        nodes: dict[int, Series] = {}
        for node, disp in trace.nodes.items():
            nodes[node] = disp.copy()
            nodes[node][:, :2] -= ground_m[support_of(node, self._lines)]
        # the ground of the whole model is that of the support of the mass centre
        accel = trace.centre_accel_mps2 - self._ground.at(trace.time_s)
        return replace(trace, nodes=nodes, centre_accel_mps2=accel)
