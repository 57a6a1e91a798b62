"""Check of `skewbridge predict` by new analyses at points between the variants of the grid.

For each bridge and abutment model, three variants inside the grid of the study are analysed under
some of its motions. The medians fitted to these runs are compared with the predicted medians.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.demands.validity import with_derived_columns
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, records_of
from skewbridge.files.text import read_yaml
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, LOADING_COLUMNS, prepared
from skewbridge.fragility.fits import FITTED, NO_EXCEEDANCE, NOT_APPLICABLE
from skewbridge.fragility.joint import JointModel, joint_table
from skewbridge.fragility.limit_states import LimitState, load_limit_states, with_column_failure
from skewbridge.fragility.paper_table import chosen_curves
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.study_tables import write_described
from skewbridge.study.analyses import StudySetup, run_in_journal, sampled
from skewbridge.study.folder import COLUMNS_FILE
from skewbridge.variant.axes import axis
from skewbridge.variant.variant import Variant

#: Number of motions of each inner variant.
MOTIONS: Final = 16
CHECK_COLUMNS: Final[dict[str, str]] = read_yaml(COLUMNS_FILE)["check_predict"]


def write_predict_check(
    setup: StudySetup,
    axes: Mapping[str, Sequence[float]],
    tables: Mapping[str, Path],
    settings: FitSettings,
    output: Path,
) -> None:
    """Run the missing analyses of the inner variants and write the table of `CHECK_COLUMNS`.

    ``tables`` has the paths of the tables ``demands``, ``joint`` and ``limit_states``.
    """
    study = read_frame(tables["demands"])
    models = study[list(BRIDGE_COLUMNS)].drop_duplicates().itertuples(index=False)
    variants = [
        Variant.at(str(bridge), str(abutment), point).normalised()
        for (bridge, abutment), point in product(models, inner_variants(axes))
    ]
    done = set(study["variant"])
    new = [variant for variant in dict.fromkeys(variants) if variant.slug not in done]
    tasks = [task for variant in new for task in sampled(setup.tasks(variant), MOTIONS)]
    rows = run_in_journal(setup, "check_predict", tasks)
    existing = with_derived_columns(study.head(0)).columns
    states = with_column_failure(load_limit_states(tables["limit_states"]), existing)
    columns = list(dict.fromkeys(state.demand for state in states))
    grid, inner = (prepared(t, columns, settings).table for t in (study, pd.DataFrame(rows)))
    checked = check_predict(read_frame(tables["joint"]), grid, inner, states, settings)
    write_described(checked, output, CHECK_COLUMNS)


def inner_variants(grid: Mapping[str, Sequence[float]]) -> list[dict[str, float]]:
    """Return three points inside a grid, none of which is a variant of the grid.

    On the first, third, ... axis they are at 1/2, 1/4 and 3/4 of the range. On the second, fourth,
    ... axis they are at 1/2, 3/4 and 1/4. An axis with a single value keeps it. A point that would
    be a variant of the grid is moved along one axis.
    """
    points: list[dict[str, float]] = []
    for share in (0.5, 0.25, 0.75):
        point: dict[str, float] = {}
        for number, (name, values) in enumerate(grid.items()):
            low, high = min(values), max(values)
            part = share if number % 2 == 0 else 1.0 - share
            value = round(low + part * (high - low), 6)
            point[name] = float(round(value)) if axis(name).is_whole else value
        if all(value in grid[name] for name, value in point.items()):
            name = next((name for name, values in grid.items() if len(set(values)) > 1), None)
            if name is None:
                problem = "the grid has one value on every axis, so no variant lies inside it"
                raise InputError(f"{problem}: add values")
            levels = sorted(set(grid[name]))
            at = min(levels.index(point[name]), len(levels) - 2)
            point[name] = levels[at] + (levels[at + 1] - levels[at]) / 3.0
        points.append(point)
    return points


def check_predict(
    joint: pd.DataFrame,
    study: pd.DataFrame,
    inner: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return one row of `CHECK_COLUMNS` per new variant inside the grid and limit state.

    The new analyses usually have fewer motions than the study. The joint models are therefore
    fitted again to the runs of the grid under these motions: both medians then have the same
    scatter from motion to motion, and their difference is the error of the joint model.
    """
    loading = list(LOADING_COLUMNS)
    same = study.merge(inner[loading].drop_duplicates(), on=loading)
    if lacking := set(inner["motion_id"]) - set(same["motion_id"]):
        raise InputError(f"the study has no runs of motion {', '.join(sorted(map(str, lacking)))}")
    key = [*BRIDGE_COLUMNS, "component", "limit_state"]
    status = joint.set_index(key)["status"].to_dict()
    fitted = records_of(joint_table(same, limit_states, settings))
    models = {tuple(row[name] for name in key): row for row in fitted}
    rows: list[dict[str, Any]] = []
    for cloud in records_of(chosen_curves(fit_study(inner, limit_states, settings), "cloud")):
        row = {name: cloud[name] for name in CHECK_COLUMNS if name in cloud}
        row |= {"n_motions": cloud["n_records"]}
        model = models.get(tuple(row[name] for name in key), {})
        stages = [status.get(tuple(row[name] for name in key)), model.get("status")]
        unfitted = [stage or NOT_APPLICABLE for stage in stages if stage != FITTED]
        if row["n_exceed"] == 0:
            row["status"] = NO_EXCEEDANCE
        elif unfitted:
            row["status"] = unfitted[0]
        else:
            predicted, analysed = JointModel(model).median(cloud)[0], cloud["theta"]
            row |= {"theta_predicted": predicted, "theta_analysed": analysed}
            inside = model["im_low"] <= predicted <= model["im_high"]
            row |= {"extrapolated": bool(cloud["extrapolated"]) or not inside}
            row |= {"error": predicted / analysed - 1.0}
            row |= {"se_analysed": cloud["var_ln_theta"] ** 0.5}
        rows.append(row)
    return pd.DataFrame(rows, columns=list(CHECK_COLUMNS))
