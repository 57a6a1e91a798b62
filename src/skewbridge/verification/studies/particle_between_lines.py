"""Figure 4 of the paper: a particle bounded by two inclined lines under a base pulse."""

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from skewbridge.verification.judgement import at_most
from skewbridge.verification.references.lcp import LcpHistory
from skewbridge.verification.references.particle import (
    Particle,
    ParticleHistory,
    run_particle,
    run_particle_lcp,
)
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study

DURATION_S: Final = 3.0
_LCP_STEP_S: Final = 2.0e-5
_LCP: Final = "own Moreau-Jean solver at h = 1e-6 s (docs/theory/verification.md)"
_FIRST_CONTACT: Final = "closed form of free flight"
# Peaks of ux, uy, ut and the sum of normal impulses, by restitution; friction 0.1.
# source: docs/theory/verification.md, computed at h = 1e-6 s.
LCP_PEAKS: Final = {
    0.0: (0.152081, 0.089238, 0.164634, 3133.04),
    0.6: (0.153500, 0.082905, 0.163860, 5465.14),
    1.0: (0.166286, 0.086752, 0.186432, 4835.24),
}
_CLOSE: Final = 0.03  # of the gap: what Kn = 1e9 N/m lets the particle penetrate
FIRST_CONTACT_S: Final = 0.0764011


def run(study: Study) -> None:
    """Run the study."""
    rigid = {e: _rigid_particle(study, e) for e in LCP_PEAKS}[0.6]
    particle = Particle(kn_n_per_m=1.0e9)
    # Step times the frequency of the mass on the penalty: 0.05.
    dt = 0.05 * (particle.mass_kg / particle.kn_n_per_m) ** 0.5
    history = run_particle(particle, dt, DURATION_S, keep=lambda k: k % 10 == 0)
    compare_with_lcp(study, particle, history, rigid)
    study.figures["particle"] = _figure(particle, history, rigid)


def _rigid_particle(study: Study, restitution: float) -> LcpHistory:
    """Run the rigid particle with a tabulated restitution and compare its peaks."""
    *peaks, impulse = LCP_PEAKS[restitution]
    particle = Particle(restitution=restitution)
    history = run_particle_lcp(particle, _LCP_STEP_S, DURATION_S)
    found = (*np.abs(history.q).max(axis=0), np.abs(history.q @ np.array(particle.tangent)).max())
    name = f"LCP, restitution {restitution:g}:"
    for quantity, value, exact in zip(("ux", "uy", "ut"), found, peaks, strict=True):
        text = f"{name} peak {quantity} (m)"
        # Time stepping converges slowly without loss at impact: shown, not judged.
        study.relative(text, value, exact, None if restitution == 1.0 else 1e-3, _LCP)
    if restitution < 1.0:
        total = float(history.normal_impulses_ns.sum())
        study.relative(f"{name} normal impulse (N s)", total, impulse, 5e-3, _LCP)
        if restitution == 0.6:
            ratio = float(np.abs(history.tangent_impulses_ns).sum()) / total
            study.absolute(f"{name} friction over normal impulse", ratio, 0.1, 1e-3, "Coulomb")
    return history


def compare_with_lcp(
    study: Study, particle: Particle, history: ParticleHistory, rigid: LcpHistory
) -> None:
    """Compare the penalty particle of OpenSees with the rigid one."""
    n, t = np.array(particle.normal), np.array(particle.tangent)
    d = particle.half_gap_m
    ux, uy, ut, _ = LCP_PEAKS[0.6]
    peaks = (*np.abs(history.position_m).max(axis=0), np.abs(history.position_m @ t).max())
    for quantity, value, exact in zip(("ux", "uy", "ut"), peaks, (ux, uy, ut), strict=True):
        study.relative(f"OpenSees, Kn 1e9: peak {quantity} (m)", value, exact, 0.015, _LCP)
    normal = history.position_m @ n
    reference = np.interp(history.t_s, rigid.t_s, rigid.q @ n)
    rms = float(np.sqrt(np.mean((normal - reference) ** 2)))
    study.at_most("OpenSees, Kn 1e9: RMS of un against LCP over gap", rms / d, _CLOSE, _LCP)
    depth = max(ledger.max_penetration_m for ledger in history.ledgers)
    study.at_most("OpenSees, Kn 1e9: penetration over gap", depth / d, _CLOSE, "penalty")
    case = "OpenSees, Kn 1e9 N/m"
    judged = at_most(
        "RMS of the normal motion against the rigid particle over the gap", rms / d, _CLOSE
    )
    study.states("node to line", case, judged)
    judged = at_most("penetration over the gap", depth / d, _CLOSE)
    study.states("penalties enforce", case, judged)
    for name, motion in ((case, normal), ("rigid, restitution 0.6", rigid.q @ n)):
        beyond = float(np.abs(motion).max()) / d - 1.0
        judged = at_most("normal motion beyond the gap, over it", beyond, _CLOSE)
        study.states("bounded by the lines", name, judged)
    first_s = float(history.t_s[np.flatnonzero(np.abs(normal) > d)[0]])
    study.absolute("OpenSees: first contact (s)", first_s, FIRST_CONTACT_S, 6e-4, _FIRST_CONTACT)
    excess = np.abs(history.friction_n) - particle.friction * np.maximum(0.0, history.normal_n)
    largest = particle.friction * float(history.normal_n.max())
    study.at_most(
        "OpenSees: friction beyond the cone over its largest",
        max(0.0, float(excess.max())) / largest,
        0.1,
        "one step of the predicted compression at impact",
    )


def _figure(particle: Particle, history: ParticleHistory, rigid: LcpHistory) -> Figure:
    figure, axes = style.panels(2, 2, height_in=4.8)
    (plane, across), (along, force) = axes
    d, n, t = particle.half_gap_m, np.array(particle.normal), np.array(particle.tangent)
    reach = np.array([-0.2, 0.2])
    for offset, colour in ((0.0, style.BLACK), (d, style.GREEN), (-d, style.BLUE)):
        x, y = (1000.0 * (reach[:, None] * t + offset * n)).T
        style.line(plane, x, y, colour, ls="--" if offset else "-")
    x, y = 1000.0 * history.position_m.T
    style.line(plane, x, y, style.ORANGE)
    style.label(plane, "ux (mm)", "uy (mm)", "path of the particle")
    for axis, direction, name, title in (
        (across, n, "un", "normal"), (along, t, "ut", "along the lines")
    ):  # fmt: skip
        style.line(
            axis, rigid.t_s, 1000.0 * rigid.q @ direction, style.GREY, "LCP, e = 0.6", lw=2.2
        )
        style.line(
            axis, history.t_s, 1000.0 * history.position_m @ direction, style.ORANGE, "OpenSees"
        )
        style.label(axis, "time (s)", f"{name} (mm)", title)
    for side in (d, -d):
        across.axhline(1000.0 * side, color=style.BLUE, lw=0.8, ls="--")
    style.legend(along, loc="upper right")
    style.line(force, history.t_s, history.normal_n.sum(axis=1) / 1000.0, style.BLUE, "N", lw=0.8)
    style.line(
        force, history.t_s, history.friction_n.sum(axis=1) / 1000.0, style.ORANGE, "F", lw=0.8
    )
    style.label(force, "time (s)", "force (kN)", "contact forces of both lines")
    style.legend(force)
    return figure
