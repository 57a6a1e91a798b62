"""Synthetic demands tables in the contract of results/demands.parquet."""

from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from skewbridge.demands.validity import BEYOND_MODEL, COLUMN_FAILURE_RATIO, FAILURE_DEMANDS
from skewbridge.fragility import curves, demand_model, effects, limit_states
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.settings import FitSettings
from skewbridge.variant.variant import Variant

IM = "im_saavg_rotd50_g"
_ALL = limit_states.load_limit_states(Path(__file__).parents[1] / "config" / "limit_states.yaml")
STATES = [state for state in _ALL if state.component != "joint_unseating"]
SETTINGS = FitSettings(im=IM)
DRIFT_ENTRY = {
    "component": "column_drift", "demand": "column_drift_ratio", "unit": "percent",
    "dispersion": 0.35, "citation": "test", "states": {"slight": 1.0, "moderate": 2.5},
}  # fmt: skip
DRIFT = limit_states.limit_states_of([DRIFT_ENTRY])
# ln demand = ln a + b ln im + scatter of the motion + small scatter of the run
DEMAND_MODELS = {
    "column_shear_kn": (np.log(2000.0), 0.25, 0.12), "column_shear_dcr": (np.log(0.62), 0.22, 0.10),
    "column_drift_ratio": (np.log(0.035), 1.0, 0.35),
    "column_curvature_ductility": (np.log(6.0), 1.1, 0.40),
    "column_residual_drift_ratio": (np.log(0.004), 1.5, 0.60),
    "deck_disp_m": (np.log(0.25), 1.0, 0.35), "deck_disp_x_m": (np.log(0.18), 0.9, 0.40),
    "deck_disp_y_m": (np.log(0.20), 1.0, 0.40), "deck_rotation_rad": (np.log(0.004), 1.0, 0.45),
    "unseating_m": (np.log(0.15), 1.0, 0.40), "bearing_disp_m": (np.log(0.22), 1.0, 0.38),
    "abutment_passive_m": (np.log(0.08), 1.2, 0.5), "abutment_active_m": (np.log(0.02), 0.8, 0.5),
    "abutment_transverse_m": (np.log(0.06), 0.9, 0.45),
    "backwall_force_kn": (np.log(4000.0), 0.5, 0.3),
    "shear_key_force_kn": (np.log(1500.0), 0.4, 0.3), "shear_key_disp_m": (np.log(0.05), 1.0, 0.5),
}  # fmt: skip
#: States of the failure modes of a column and of their union.
FAILURES = limit_states.with_column_failure([], {*FAILURE_DEMANDS.values(), COLUMN_FAILURE_RATIO})


def states_of(component):
    return [state for state in _ALL if state.component == component]


def ready(table, states):
    return prepared(table, list(dict.fromkeys(state.demand for state in states)), SETTINGS).table


def models_of(table, states):
    return demand_model.fit_models(ready(table, states), states, SETTINGS)


def curves_of(table, states):
    return curves.fit_study(models_of(table, states), states, SETTINGS)


def two_mode_runs(seed: int, motions: int = 12) -> pd.DataFrame:
    """Return one variant whose columns fail in shear or flexure; the first failure ends a run."""
    rng = np.random.default_rng(seed)
    im = np.exp(rng.uniform(np.log(0.08), np.log(2.2), motions))
    rho = rng.uniform(-0.6, 0.95)
    residual = rng.multivariate_normal([0.0, 0.0], [[1.0, rho], [rho, 1.0]], motions)
    median, slope = np.exp(rng.uniform(np.log(0.5), np.log(2.5), 2)), rng.uniform(0.4, 1.5, 2)
    ratio = np.exp(slope * np.log(im[:, None] / median) + rng.uniform(0.08, 0.5, 2) * residual)
    kinds = np.where(ratio[:, 0] >= ratio[:, 1], "shear", "flexure")
    kinds = np.where(ratio.max(axis=1) > 1.0, kinds, "")
    # the other demand is known up to the failure only
    so_far = np.minimum(ratio * rng.uniform(0.5, 1.0, (motions, 1)), 0.99)
    ratio = np.where((kinds == "")[:, None], ratio, so_far)
    ratio[kinds == "shear", 0] = ratio[kinds == "flexure", 1] = 1.001
    place = {"abutment": "contact_friction", "skew_deg": 0.0, "gap_mm": 25.0, "friction": 0.5}
    keys = [f"{seed}-{number}" for number in range(motions)]
    loading = {"motion_id": keys, "run_key": keys, "scale": 1.0, "incidence_deg": 0.0, IM: im}
    demands = dict(zip(FAILURE_DEMANDS.values(), ratio.T, strict=True))
    name = {"variant": f"v{seed:03d}", "bridge": f"b{seed:03d}", "status": "ok"}
    return pd.DataFrame(name | place | loading | demands | {BEYOND_MODEL: kinds})


def synthetic_demands(
    *,
    bridge: str = "osb1",
    abutment: str = "contact_friction",
    motions: int = 16,
    skews=(0, 30, 45),
    gaps=(25, 51),
    frictions=(0, 50),
    scales=(1.0,),
    seed: int = 1,
    run_scatter: float = 0.03,
    friction_effect: float = -0.10,
    skew_effect: float = 0.20,
) -> pd.DataFrame:
    """Return a table in which friction 0.5 changes deck rotation and skew changes it too."""
    rng = np.random.default_rng(seed)
    im = np.exp(np.linspace(np.log(0.1), np.log(1.5), motions))
    residual = {name: rng.normal(size=motions) for name in DEMAND_MODELS}
    rows = []
    for skew, gap, friction, m, scale in product(skews, gaps, frictions, range(motions), scales):
        variant = Variant(bridge=bridge, abutment=abutment, skew_deg=skew, gap_mm=gap,
                          friction_pct=friction)  # fmt: skip
        row = {
            "variant": variant.slug, "bridge": bridge, "abutment": abutment, "skew_deg": skew,
            "gap_mm": gap, "friction": friction / 100, "motion_id": f"m{m:02d}",
            "run_key": f"{variant.slug}-{m:02d}", "scale": scale, "incidence_deg": 0.0,
            IM: im[m] * scale, "status": "ok",
        }  # fmt: skip
        for name, (ln_a, b, s) in DEMAND_MODELS.items():
            ln_d = ln_a + b * np.log(im[m] * scale) + s * residual[name][m]
            ln_d += run_scatter * rng.normal()
            if name == "deck_rotation_rad":
                ln_d += friction_effect * friction / 50 + skew_effect * skew / 30
            row[name] = np.exp(ln_d)
        rows.append(row)
    return pd.DataFrame(rows)


def friction_rows(scatter, motions=(12, 12), *, demand="deck_disp_m", ratio=1.0, level=0.90):
    """Return rows of an effect of friction: pooled, and of its pairs of variants at two gaps."""
    shared = {"bridge": "b", "abutment": "a", "quantity": "demand", "demand": demand}
    shared |= {"axis": "friction", "from_value": 0.0, "to_value": 0.5, "margin": 0.05}
    errors = np.divide(scatter, np.sqrt(motions))
    pairs = zip(motions, scatter, errors, (25.0, 51.0), strict=True)
    pooled = (max(motions), np.hypot(*scatter) / 2.0, np.hypot(*errors) / 2.0, None)
    rows = []
    for number, sd, error, gap_mm in (pooled, *pairs):
        half = stdtrit(number - 1, 0.5 + 0.5 * level) * error
        place = {"scope": "variant", "gap_mm": gap_mm} if gap_mm else {"scope": "pooled"}
        row = {"ratio": ratio, "ci_low": ratio * np.exp(-half), "ci_high": ratio * np.exp(half)}
        row |= {"scatter": sd, "dof": number - 1, "n_pairs": number, "n_discordant": 0}
        rows.append(shared | row | place | {"level": level})
    return rows


def paired_effects(demands, columns=None, settings=SETTINGS, *, jobs=1) -> pd.DataFrame:
    return effects.effect_tables(demands, columns, settings, jobs=jobs).effects


def runs_of_one_variant(variant: str, bridge: str, skew_deg: int, im) -> pd.DataFrame:
    """Complete runs of a variant under one motion per value of Sa(1.0 s), without demands."""
    given = {
        "variant": variant, "bridge": bridge, "abutment": "contact_friction", "skew_deg": skew_deg,
        "gap_mm": 25, "friction": 0.5, "scale": 1.0, "incidence_deg": 0.0, "status": "ok",
        "complete": True, "collapse_criterion": "", "im_sa_1p000_rotd50_g": im,
    }  # fmt: skip
    return pd.DataFrame(given).assign(motion_id=[f"m{number:02d}" for number in range(len(im))])
