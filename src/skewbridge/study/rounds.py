"""Rounds of a study that runs until its headline effects are decided: plans of motions.

A round adds motions of the ordered suite to the variants that are needed to decide open effects.
It considers pooled effects on headline demands and on median capacities of headline states. The
plan of a round has the number of motions of every variant, based on demands of earlier rounds.

References:
    Neyman (1934), J. R. Stat. Soc. 97(4):558-625: allocation in proportion to
    scatter / sqrt(cost).
"""

import json
import logging
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.demands.validity import with_derived_columns
from skewbridge.files.tables import read_frame, records_of
from skewbridge.files.text import read_json, write_text
from skewbridge.fragility import limit_states, verdicts
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.demand_table import axis_names, prepared
from skewbridge.fragility.effects import effect_tables, median_effects
from skewbridge.fragility.settings import EFFECT_CONFIDENCE
from skewbridge.study.analyses import StudySetup, analyses_s
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import ALL_DECIDED, OUT_OF_REACH, OUT_OF_TIME, round_line
from skewbridge.study.processes import CLOCK, PROGRESS_LOG
from skewbridge.study.progress import JOB_START_S, measured_speed, other_work_s
from skewbridge.variant.grid import expand_grid

progress_logger = logging.getLogger(PROGRESS_LOG)

# ASSUME an effect is worth its analyses if the probability of deciding it is at least this
LEAST_CHANCE: Final = 0.2


def targets(
    effects: pd.DataFrame,  # headline effects with verdicts at the looks so far
    motions: Mapping[str, int],  # motions of each variant so far, the first of the suite
    cost_s: Mapping[str, float],  # processor time of an analysis, by variant
    variants: pd.DataFrame,  # bridge, abutment model and axes of each variant, indexed by its name
    looks: Sequence[int],  # number of motions at each look
    level: float,  # two-sided joint level of all intervals of a cell
) -> tuple[pd.DataFrame, list[dict[str, int]]]:
    """Return the pooled effects and, for each, the number of motions by variant that decides it.

    Their column ``needed`` is the number of motions if all pairs of variants get the same. Pairs
    with small scatter or long analyses get fewer (Neyman 1934). No motions are planned for a
    decided effect, or if a decision after the last round is less likely than `LEAST_CHANCE`.
    """
    axes = axis_names(variants)
    pooled = effects[effects["scope"] == "pooled"].reset_index(drop=True)
    single = effects[effects["scope"] == "variant"]
    names = dict(zip(_keys(variants, axes), map(str, variants.index), strict=True))
    for end in ("from_value", "to_value"):
        pair_ends = single[["bridge", "abutment", *axes]].copy()
        for axis in axes:
            pair_ends[axis] = pair_ends[axis].where(single["axis"] != axis, single[end])
        single = single.assign(**{f"{end}_variant": [names[key] for key in _keys(pair_ends, axes)]})
    pairs = dict(iter(single.groupby(list(verdicts.CELL))))
    level_at_last = float(verdicts.levels_at(np.array([float(looks[-1])]), looks, level)[0])
    needed: list[float] = []
    by_effect: list[dict[str, int]] = []
    for row in pooled.to_dict("records"):
        cell = pairs[tuple(row[name] for name in verdicts.CELL)]
        pair_names = list(zip(cell["from_value_variant"], cell["to_value_variant"], strict=True))
        n_now = max(min(motions[a], motions[b]) for a, b in pair_names)
        # the share of motions without an exact pair stays the same
        motions_per_pair = n_now / max(row["dof"] + 1, 1.0)
        at_last_look = row | {"level": level_at_last}
        n_all = verdicts.motions_to_decide(at_last_look) * motions_per_pair
        n_least = verdicts.motions_to_decide(at_last_look, LEAST_CHANCE) * motions_per_pair
        needed.append(float(np.ceil(n_all)))
        by_effect.append({})
        if row["verdict"] in verdicts.DECIDED or not n_least <= looks[-1]:
            continue
        n_all = min(n_all, looks[-1])
        scatter = cell["scatter"].fillna(0.0).to_numpy(dtype=np.float64)
        scatter = np.maximum(scatter, 1e-3 * scatter.max() + 1e-12)
        sqrt_cost = np.sqrt([cost_s[a] + cost_s[b] for a, b in pair_names])
        relative_n = scatter / sqrt_cost * np.sum(scatter * sqrt_cost) / np.sum(scatter**2)
        for pair, ratio in zip(pair_names, relative_n.tolist(), strict=True):
            for name in pair:
                count = max(by_effect[-1].get(name, 0), int(np.ceil(max(n_all, n_now + 1) * ratio)))
                by_effect[-1][name] = min(count, looks[-1])
    is_planned = [any(n > motions[name] for name, n in cell.items()) for cell in by_effect]
    return pooled.assign(needed=needed, asked=is_planned), by_effect


def _keys(table: pd.DataFrame, axes: Sequence[str]) -> list[tuple[Any, ...]]:
    columns = ["bridge", "abutment", *axes]
    return list(table[columns].itertuples(index=False, name=None))


def whole_blocks(by_variant: Mapping[str, int], bridges: Mapping[str, str]) -> dict[str, int]:
    """Return the number of motions that decides an effect, the same in all variants of a bridge."""
    by_bridge: dict[str, int] = {}
    for slug, number in by_variant.items():
        by_bridge[bridges[slug]] = max(number, by_bridge.get(bridges[slug], 0))
    return {slug: by_bridge[bridge] for slug, bridge in bridges.items() if bridge in by_bridge}


def next_motions(
    by_effect: Iterable[Mapping[str, int]],  # motions by variant that decide each cell
    motions: Mapping[str, int],  # motions of each variant so far
    cost_s: Mapping[str, float],  # time that one more motion of a variant adds to the round
    looks: Sequence[int],  # number of motions at each look
    time_s: float,  # time available for the round
) -> dict[str, int]:
    """Return the number of motions of each variant after the next round.

    Effects are added in order of the cost of a decision, while the round fits into ``time_s``.
    """

    def left_s(effect_motions: Mapping[str, int]) -> float:
        return sum(max(n - motions[name], 0) * cost_s[name] for name, n in effect_motions.items())

    following = dict(motions)
    for cell in sorted(by_effect, key=left_s):
        extended = dict(following)
        for name, number in cell.items():
            if number > motions[name]:
                extended[name] = next(look for look in looks if look > motions[name])
        if sum((n - motions[name]) * cost_s[name] for name, n in extended.items()) <= time_s:
            following = extended
    return following


def first_motions(
    motions: Mapping[str, int], cost_s: Mapping[str, float], first: int, time_s: float
) -> dict[str, int]:
    """Return the number of motions of each variant after the next round: ``first``, or fewer.

    A round that would take more than half of the time is split in two.
    """
    one_motion_s = sum(cost_s.values())
    added = min(first - min(motions.values()), max(int(time_s / one_motion_s), 0))
    # a round of up to three motions is not split, because each round starts all jobs again
    if added > 3 and added * one_motion_s > time_s / 2:
        added = (added + 1) // 2
    return {name: max(n, min(first, n + added)) for name, n in motions.items()}


def plan_round(study: StudyConfig, number: int, earlier: Sequence[Path], output: Path) -> None:
    """Write the plan of a round (1, 2, ...) from the demands of all earlier rounds; log a line.

    A JSON object: ``motions`` of each variant before and after, ``analyses``, ``decided`` and
    ``cells`` (pooled effects) so far, and ``ended``, why the study ends, see `round_line`, or null.
    """
    entered_s = time.monotonic()
    design, setup = study.design, StudySetup.of(study)
    plans = [read_json(setup.folder.round(n)) for n in range(1, number)]
    slugs = sorted(variant.slug for variant in expand_grid(study.grid))
    motions = {slug: plans[-1]["motions"][slug][1] if plans else 0 for slug in slugs}
    analyses = sum(len(setup.planned_tasks(slug)) for slug in slugs)
    per_motion = analyses / len(slugs) / len(setup.motion_ids)
    demands, speed = pd.DataFrame(), 1.0
    analysis_s = dict.fromkeys(slugs, analyses_s(study, setup.durations_s) / analyses)
    if earlier:
        demands = pd.concat(map(read_frame, earlier), ignore_index=True)
        # NaN, left out: all workers of a variant died
        mean_s = demands.groupby("variant")["wall_s"].mean().dropna()
        analysis_s = {slug: float(mean_s.get(slug, mean_s.mean())) for slug in slugs}
        speed = measured_speed(records_of(demands), study.analysis, "wall_s")
    began_s, cores = map(float, os.environ.get(CLOCK, f"{time.time()} 1").split())
    cost_s = {slug: analysis_s[slug] * per_motion / cores for slug in slugs}
    cells, by_effect, ended = pd.DataFrame(), [], None
    is_first = min(motions.values()) < design.first
    if not is_first:
        cells, by_effect = _looked_at(study, demands, plans, motions, analysis_s)
        if study.motions.blocks:
            bridges = {variant.slug: variant.bridge for variant in expand_grid(study.grid)}
            by_effect = [whole_blocks(cell, bridges) for cell in by_effect]
    # the next plan takes as long as this one did
    planning_s = time.monotonic() - entered_s
    starts_s = JOB_START_S * speed * (1.0 + len(slugs) / cores)
    left_s = began_s + 3600.0 * design.hours - time.time() - planning_s - starts_s
    left_s -= other_work_s(study, setup.durations_s, speed, cores)
    decided = 0
    if is_first:
        # ASSUME analyses take at most ten times as long as forecast before any is measured
        after = first_motions(motions, cost_s, design.first, left_s if earlier else 0.1 * left_s)
        if not earlier:  # a study has at least one motion
            after = {slug: max(n, 1) for slug, n in after.items()}
        ended = OUT_OF_TIME if after == motions else None
    else:
        after = next_motions(by_effect, motions, cost_s, design.looks, left_s)
        decided = int(cells["verdict"].isin(verdicts.DECIDED).sum())
        if after == motions:
            ended = OUT_OF_TIME if cells["asked"].any() else OUT_OF_REACH
            ended = ended if decided < len(cells) else ALL_DECIDED
    added = {slug: after[slug] - motions[slug] for slug in slugs}
    plan = {
        "round": number,
        "ended": ended,
        "hours": design.hours,
        "motions": {slug: [motions[slug], after[slug]] for slug in slugs},
        "analyses": round(sum(added.values()) * per_motion),
        "analyses_before": len(demands),
        "forecast_s": round(sum(n * cost_s[slug] for slug, n in added.items()), 1),
        "decided": decided,
        "cells": json.loads(cells.to_json(orient="records")),
    }
    write_text(output, json.dumps(plan, indent=1) + "\n")
    progress_logger.info("%s", round_line(plan))


def _looked_at(
    study: StudyConfig,
    demands: pd.DataFrame,
    plans: Sequence[Mapping[str, Any]],
    motions: Mapping[str, int],
    mean_s: Mapping[str, float],
) -> tuple[pd.DataFrame, list[dict[str, int]]]:
    settings, looks = study.fragility, study.design.looks
    states = limit_states.load_limit_states(Path(settings.limit_states))
    columns = with_derived_columns(demands.head(0)).columns
    states = limit_states.with_column_failure(states, columns)
    names = list(dict.fromkeys(state.demand for state in states))
    rows = prepared(demands, names, settings).table
    headline = [state for state in states if state.key in limit_states.HEADLINE_STATES]
    on_demands = effect_tables(rows, demands_for("headline", rows.columns), settings).effects
    models = fit_models(rows, headline, settings)
    effects = pd.concat([on_demands, median_effects(models, headline, settings)], ignore_index=True)
    history = pd.DataFrame([cell for plan in plans for cell in plan["cells"]])
    effects = verdicts.kept(
        verdicts.at_looks(effects, looks, verdicts.runs_per_motion(demands)), history
    )
    columns = ["bridge", "abutment", *axis_names(rows)]
    variants = rows.drop_duplicates("variant").set_index("variant")[columns]
    cells, by_effect = targets(effects, motions, mean_s, variants, looks, EFFECT_CONFIDENCE)
    return cells[[name for name in verdicts.ROUND_COLUMNS if name in cells]], by_effect
