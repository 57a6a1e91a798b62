"""A bridge with contact and friction against a model written without the builders of the package.

Both share the data of the bridge (numbers), the concrete of Mander and the motion. Everything else
is other: a spine with element loads, rigid links, fibers by patches, HingeRadau, one bearing
element per pad, five wall points by Simpson's rule, and the contact element of OpenSees, which
iterates friction within the step and counts displacements from its creation. The plastic part of
the backfill is HyperbolicGapMaterial in series with a negative spring that cancels its elastic
part, four fifths of the flexibility of the soil."""

from functools import partialmethod
from itertools import pairwise, product
from math import cos, exp, pi, radians, sin, sqrt

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.bridge.section import STEELS, core_concrete, cover_concrete
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.studies.paper_runs import strongest_motions

G = 9.80665
PER_SPAN = 10
SIMPSON = (1, 4, 2, 4, 1)
ALGORITHMS = ("Newton", "NewtonLineSearch")  # of steps that failed


class Independent:
    def __init__(self, variant, options):
        self.bridge = load_bridge(variant.bridge)
        self.o, self.mu = options, variant.friction
        self.gap, self.skew = variant.gap_mm * 1e-3, radians(variant.skew_deg)
        self.last = 0
        self.damped: list[int] = []
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        self.spine()
        self.bent()
        self.ends = [self.end(-1.0, self.nodes[0]), self.end(1.0, self.nodes[-1])]
        static_steps(10, "UmfPack", 1e-10)
        ops.loadConst("-time", 0.0)
        ops.wipeAnalysis()
        for end in self.ends:
            self.joint(end)

    def made(self, command, *kind_and_args):
        """Call a command that takes a kind, a new tag and its arguments; return the tag."""
        kind, *args = kind_and_args
        self.last += 1
        command(kind, self.last, *args)
        return self.last

    def node(self, *place, mass=None, fix=None):
        self.last += 1
        ops.node(self.last, *place)
        if mass:
            ops.mass(self.last, *mass)
        if fix:
            ops.fix(self.last, *fix)
        return self.last

    element = partialmethod(made, ops.element)
    material = partialmethod(made, ops.uniaxialMaterial)

    def spine(self):
        d = self.bridge.deck
        line = d.line_load_kn_per_m * 1e3
        diaphragm = d.diaphragm_weight_kn * 1e3 / cos(self.skew)  # along the skewed end
        self.level = self.made(ops.geomTransf, "Linear", 0.0, 0.0, 1.0)
        self.nodes = []
        half = self.bridge.length_m / 2  # of two equal spans
        for at in np.linspace(-half, half, 2 * PER_SPAN + 1).tolist():
            is_end = abs(at) == half
            upright = line * half / PER_SPAN / (1 + is_end) / G
            m = upright + is_end * diaphragm / G
            turning = (m * (d.width_m**2 + d.depth_m**2) / 12, m * d.depth_m**2 / 12)
            # lumps of half elements turn too much: less their own inertia about the node
            own = 0.0 if is_end else upright * (half / PER_SPAN) ** 2 / 12
            edge = d.width_m / cos(self.skew)
            mass = (m, m, upright, *turning, m * edge**2 / 12 + own)
            self.nodes.append(self.node(at, 0.0, d.centroid_above_soffit_m, mass=mass))
        e = d.elastic_modulus_gpa * 1e9
        self.deck = (e, e / 2.4)
        i = (d.torsion_constant_m4, d.inertia_vertical_m4, d.inertia_transverse_m4)
        for pair in pairwise(self.nodes):
            args = (*pair, d.area_m2, *self.deck, *i, self.level)
            element = self.element("elasticBeamColumn", *args)
            ops.eleLoad("-ele", element, "-type", "-beamUniform", 0.0, -line, 0.0)
            self.damped.append(element)
        for node in (self.nodes[0], self.nodes[-1]):
            ops.load(node, 0.0, 0.0, -diaphragm, 0.0, 0.0, 0.0)

    def bent(self):
        b, d, (bent,) = self.bridge, self.bridge.deck, self.bridge.bents
        c = b.column
        centre = self.nodes[PER_SPAN]
        width, depth = bent.cap_width_m, bent.cap_depth_m
        # a bent parallel to the abutments: longer by 1 / cos, columns below the same girders
        along = (-sin(self.skew), cos(self.skew))
        half, edge = (w / 2 / cos(self.skew) for w in (bent.column_spacing_m, d.width_m))
        weight = bent.cap_weight_kn * 1e3 / cos(self.skew)
        column = c.unit_weight_kn_per_m3 * 1e3 * pi * c.diameter_m**2 / 4 * bent.clear_height_m
        # dead load of two equal spans enters the cap evenly over the width of the deck
        load = 1.25 * d.line_load_kn_per_m * 1e3 * b.spans_m[0] + weight
        ops.load(centre, 0.0, 0.0, load - weight, 0.0, 0.0, 0.0)
        z = d.centroid_above_soffit_m
        places = (-edge, -half, 0.0, half, edge)
        cap = [self.node(s * along[0], s * along[1], z) if s else centre for s in places]
        i = (100 * width * depth * (width**2 + depth**2) / 12, width * depth**3 / 12)
        i = (*i, depth * width**3 / 12)
        for pair in pairwise(cap):
            args = (*pair, width * depth, *self.deck, *i, self.level)
            element = self.element("elasticBeamColumn", *args)
            self.damped.append(element)
            ops.eleLoad("-ele", element, "-type", "-beamUniform", 0.0, -load / 2 / edge, 0.0)
        self.add_mass(centre, weight / G)
        self.columns = []
        upright = self.made(ops.geomTransf, "PDelta", cos(self.skew), sin(self.skew), 0.0)
        integration = self.hinges()
        for joint in (cap[1], cap[3]):
            bends, (x, y, _) = int(b.base != "pinned"), ops.nodeCoord(joint)
            base = self.node(x, y, -bent.clear_height_m, fix=(1, 1, 1, bends, bends, 1))
            top = self.node(x, y, 0.0)
            ops.rigidLink("beam", joint, top)
            self.damped.append(self.element("forceBeamColumn", base, top, upright, integration))
            self.columns.append((top, bent.clear_height_m))
            ops.load(joint, 0.0, 0.0, -column, 0.0, 0.0, 0.0)
            self.add_mass(joint, column / 2 / G)

    def add_mass(self, node, mass):
        before = [ops.nodeMass(node, dof) for dof in range(1, 7)]
        ops.mass(node, *(m + mass * (i < 3) for i, m in enumerate(before)))

    def hinges(self):
        c, steel = self.bridge.column, STEELS[self.bridge.column.steel]
        core, cover = core_concrete(c), cover_concrete(c)
        crushed = float(core.stress_pa(core.ultimate_strain))

        def concrete(peak, strain, end, ultimate):
            return self.material("Concrete01", -peak, -strain, -end, -ultimate)

        peak_strain = 2 * core.peak_pa / core.modulus_pa
        kept = 0.2 * core.peak_pa
        stays = concrete(kept, peak_strain, kept, core.ultimate_strain)
        goes = concrete(core.peak_pa - kept, peak_strain, crushed - kept, core.ultimate_strain)
        ends = self.material("MinMax", goes, "-min", -core.ultimate_strain)
        confined = self.material("Parallel", ends, stays)
        strain = 2 * cover.peak_pa / cover.modulus_pa
        spalls = concrete(cover.peak_pa, strain, 0.0, cover.ultimate_strain)
        shape = (steel.hardening_ratio, 18.5, 0.925, 0.15)
        bar = self.material("Steel02", steel.yield_pa, steel.modulus_pa, *shape)
        limits = ("-min", -core.ultimate_strain, "-max", steel.rupture_strain)
        bar = self.material("MinMax", bar, *limits)
        e = c.elastic_modulus_gpa * 1e9
        gross = pi * c.diameter_m**4 / 64
        torsion = c.torsion_ratio * 2 * gross
        hinge = self.made(ops.section, "Fiber", "-GJ", torsion * e / 2.4)
        r = c.core.corner_m / 2
        ops.patch("circ", confined, 24, 10, 0.0, 0.0, 0.0, r, 0.0, 360.0)
        ops.patch("circ", spalls, 24, 2, 0.0, 0.0, r, c.diameter_m / 2, 0.0, 360.0)
        area = c.bar_area_mm2 * 1e-6
        ops.layer("circ", bar, c.bar_count, area, 0.0, 0.0, c.bar_line.corner_m / 2)
        inertia = c.cracked_stiffness_ratio * gross
        area = pi * c.diameter_m**2 / 4
        flexible = (e, area, inertia, inertia, e / 2.4, torsion)
        elastic = self.made(ops.section, "Elastic", *flexible)
        length = bent_capacity(self.bridge, 0, self.o.hinge_rule).hinge_length_m
        base = elastic if self.bridge.base == "pinned" else hinge
        ends = (base, length, hinge, length, elastic)
        return self.made(ops.beamIntegration, "HingeRadau", *ends)

    def end(self, sign, node):
        d, a = self.bridge.deck, self.bridge.abutment
        normal = (sign * cos(self.skew), sign * sin(self.skew))
        tangent = (-normal[1], normal[0])
        x = sign * self.bridge.length_m / 2
        half = d.width_m / cos(self.skew) / 2

        def point(along, offset):
            place = (x + offset + along * tangent[0], along * tangent[1], 0.0)
            made = self.node(*place)
            ops.rigidLink("beam", node, made)
            return made

        p = a.pads
        k, f = p.shear_stiffness_kn_per_m * 1e3, p.yield_force_kn * 1e3
        vertical = self.material("ENT", p.vertical_stiffness_mn_per_m * 1e6)
        soft = self.material("Elastic", 1.0)
        for i in range(p.count):
            along = (i - (p.count - 1) / 2) * p.spacing_m * 2 * half / d.width_m
            top = point(along, 0.0)
            at = ops.nodeCoord(top)
            seat = self.node(at[0], at[1], -p.height_m, fix=(1,) * 6)
            springs = ("-P", vertical, "-T", soft, "-My", soft, "-Mz", soft)
            args = (seat, top, k, f, p.hardening_ratio, 0.0, 3.0, *springs, "-orient", *normal, 0.0)
            self.element("elastomericBearingPlasticity", *args)
        face = sign * d.diaphragm_thickness_m / 2 / cos(self.skew)
        n = len(SIMPSON) - 1
        walls = [point(half * (2 * i / n - 1), face) for i in range(n + 1)]
        return {"normal": normal, "tangent": tangent, "walls": walls, "half": half}

    def joint(self, end):
        a = self.bridge.abutment
        (nx, ny), (_, ty) = end["normal"], end["tangent"]
        reduced = exp(-abs(self.skew) * 180 / pi / 45)
        data = a.backfill
        higher = a.wall_height_m / data.reference_height_m
        # skew leaves the initial stiffness and the closure at strength, F / (K (1 - ratio))
        stiff = data.stiffness_mn_per_m * 1e6 * a.wall_width_m * higher
        ratio = 1.0 - reduced * (1.0 - data.failure_ratio)
        exponent = self.o.backfill_height_exponent
        strength = data.ultimate_kn * 1e3 * a.wall_width_m * higher**exponent * reduced
        w, h = a.wall_width_m / 0.3048, a.wall_height_m / 0.3048
        wing = a.wing_length_ratio * a.wing_participation * a.wing_effectiveness
        wing_k = wing * w * (5.5 * h + 20) * 4448.2216 / 0.0254
        wing_f = wing * w * 5.5 * h**2.5 / (1 + 2.37 * h) * 4448.2216
        radiation = 1760.0 * self.o.backfill_vs_mps * a.wall_width_m * a.wall_height_m
        weak = self.o.wall_restoring_n_per_m * reduced
        end["wall_nodes"] = []
        for share, deck in zip(SIMPSON, end["walls"], strict=True):
            s = share / sum(SIMPSON)
            k, c = s * stiff, s * radiation
            soil = self.material("HyperbolicGapMaterial", k, k, *(ratio, -s * strength, -1e-9))
            side = self.material("ElasticPP", s * wing_k, wing_f / wing_k)
            back = self.material("Elastic", s * weak, wing * c)
            stem = self.material("Elastic", k, 0.0, 0.0)
            waves = self.material("Elastic", 1.25 * k, c)
            less = self.material("Elastic", -1.25 * k)
            flow = self.material("Viscous", 0.01 * s * strength, 0.5)
            weakest = self.material("Elastic", 1e-4 * k)
            wall, ground = self.facing(deck, (-nx, -ny), self.gap)
            place = ops.nodeCoord(wall)
            inner, outer = (self.node(*place, fix=(0, 0, 1, 1, 1, 1)) for _ in range(2))
            self.springs(ground, inner, (-nx, -ny), (soil,), (weakest,))
            self.springs(inner, outer, (-nx, -ny), (less,), ())
            self.springs(ground, outer, (-nx, -ny), (flow, weakest), (weakest,))
            self.springs(outer, wall, (-nx, -ny), (waves,), ())
            self.springs(ground, wall, (-nx, -ny), (stem,), (side, back))
            self.contact(wall, deck, (-nx, -ny), 50 * k)
            end["wall_nodes"].append(wall)
        key = a.sacrificial_key
        k = key.force_kn[0] * 1e3 / (key.displacement_mm[0] * 1e-3)
        c = 2 * 0.10 * sqrt(k * a.key_mass_t * 1e3)
        (f0, f1, _), (u0, u1, _) = key.force_kn, key.displacement_mm
        later = (f1 - f0) / (u1 - u0) * 1e6
        pairs = zip(key.force_kn, key.displacement_mm, strict=True)
        points = [value for f, u in pairs for value in (f * 1e3, u * 1e-3)]
        for deck, sign in ((end["walls"][0], -1.0), (end["walls"][-1], 1.0)):
            inward = (0.0, -sign if ty > 0 else sign)
            shape = self.material("Hysteretic", *points, *(-v for v in points), 1.0, 1.0, 0.0, 0.0)
            node, ground = self.facing(deck, inward, self.o.transverse_gap_m)
            dash = self.material("Elastic", 0.0, c)
            first = self.material("ElasticPP", k - later, u0 * 1e-3)
            second = self.material("ElasticPP", later, u1 * 1e-3)
            self.springs(ground, node, inward, (shape, dash), (first, second, dash))
            self.contact(node, deck, inward, 50 * k)

    def facing(self, deck, normal, gap):
        """Return a node and its ground at a gap from a point of the deck at rest."""
        # the contact element counts displacements from its creation, so coordinates give the gap
        x, y, z = ops.nodeCoord(deck)
        place = (x - gap * normal[0], y - gap * normal[1], z)
        return self.node(*place, fix=(0, 0, 1, 1, 1, 1)), self.node(*place, fix=(1,) * 6)

    def springs(self, ground, node, x, across, along):
        directions = [1] * len(across) + [2] * len(along)
        given = ("-mat", *across, *along, "-dir", *directions)
        axes = (*x, 0.0, -x[1], x[0], 0.0)
        self.element("zeroLength", ground, node, *given, "-orient", *axes)

    def contact(self, node, deck, normal, kn):
        args = (node, deck, kn, kn / 5, self.mu, "-orient", *normal, 0.0, "-intType", 0)
        self.element("zeroLengthContactASDimplex", *args)

    def retry(self, end, dt):
        """Make a step that failed in smaller parts."""
        for parts, algorithm in product((4, 20, 100), ALGORITHMS):
            ops.domainChange()
            ops.algorithm(algorithm)
            if ops.analyze(round((end - ops.getTime()) / dt * parts), dt / parts) == 0:
                ops.algorithm("KrylovNewton")
                return
        raise AssertionError(f"failed at {ops.getTime()}")

    def peaks(self, motion, dt):
        data = self.bridge.damping
        low, high = 2 * pi / data.long_period_s, 2 * pi / data.short_period_s
        a0, a1 = 2 * data.ratio * low * high / (low + high), 2 * data.ratio / (low + high)
        ops.region(1, "-ele", *self.damped, "-rayleigh", a0, 0.0, 0.0, a1)
        for direction, values in enumerate(motion.along_axes(0.0), start=1):
            ops.timeSeries("Path", 10 + direction, "-dt", motion.dt_s, "-values", *values.tolist())
            ops.pattern("UniformExcitation", 10 + direction, direction, "-accel", 10 + direction)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test("EnergyIncr", 1e-7, 25)
        ops.algorithm("KrylovNewton")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient", "-noWarnings")
        tops = [node for node, _ in self.columns]
        corners = [(end["walls"][i], end["normal"]) for end in self.ends for i in (0, -1)]
        pushed = [(node, end["normal"]) for end in self.ends for node in end["wall_nodes"]]
        watched = [*tops, *(node for node, _ in (*corners, *pushed))]

        def read():
            return [value for node in watched for value in ops.nodeDisp(node)]

        rows = [read()]
        for _ in range(round(motion.duration_s / dt)):
            if ops.analyze(1, dt) != 0:
                self.retry(ops.getTime() + dt, dt)
            rows.append(read())
        moves = (np.array(rows) - rows[0]).reshape(len(rows), len(watched), 6)
        of = dict(zip(watched, moves.transpose(1, 0, 2), strict=True))

        def normal(places):
            return [of[node][:, :2] @ n for node, n in places]

        height = self.columns[0][1]
        return {
            "column_drift_ratio": max(np.hypot(*of[top][:, :2].T).max() for top in tops) / height,
            "unseating_m": max((-move).max() for move in normal(corners)),
            "abutment_passive_m": max(move.max() for move in normal(pushed)),
        }


SECONDS = 4.0
DT_S = 0.001
# The friction of the native element is of first order in the step: at skew 30, the drift with
# friction differs by 1.0 % at 1 ms and 0.5 % at 0.5 ms, unseating by 0.4 % at 0.5 ms; without
# friction they differ by 0.1 %. The iteration of the reference fails at some other steps (0.25 ms
# at skew 30). The unseating of the program with friction, skew 60, changes by 0.2 % from 1 to
# 0.5 ms and by 0.1 % from 0.5 to 0.25 ms.
NATIVE_DT_S = {(0, 30): DT_S, (0, 60): DT_S, (50, 30): DT_S / 5, (50, 60): DT_S / 5}
TOLERANCES = {"column_drift_ratio": 0.006, "unseating_m": 0.003}


@pytest.mark.slow
@pytest.mark.parametrize(("friction_pct", "skew_deg"), NATIVE_DT_S)
def test_an_independent_model_with_native_contact_agrees(friction_pct, skew_deg):
    case = variant(**{"skew_deg": skew_deg, "gap_mm": 25, "friction_pct": friction_pct})
    motion = cut_to_strongest(strongest_motions(1, 0.8)[0], SECONDS, 0.0)
    expected = Independent(case, ModelOptions()).peaks(motion, NATIVE_DT_S[friction_pct, skew_deg])
    ops.wipe()
    dt_s = DT_S / 4 if friction_pct else DT_S
    settings = {"dt_s": dt_s, "contact_dt_s": None, "event_dt_s": None, "tolerance_j": 1e-7}
    found = analysed(case, motion, **settings, reuse_tangent=False).whole_history
    assert expected["abutment_passive_m"] > 0.004  # a wall is pushed
    assert {name: found[name] for name in TOLERANCES} == {
        name: pytest.approx(expected[name], rel=tolerance) for name, tolerance in TOLERANCES.items()
    }
