"""The figures of a study: which ones there are, their captions, and their files."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.spectrum import pair_psa
from skewbridge.motions.suite import read_suite
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.fragility_effect_figures import paired_ratios, verdict_map
from skewbridge.report.fragility_figures import demand_clouds, fragility_curves
from skewbridge.report.fragility_frequency_figure import frequency_figure
from skewbridge.report.fragility_style import label
from skewbridge.report.motion_figures import suite_spectra
from skewbridge.report.run_figures import displacement_figure, hysteresis_figure
from skewbridge.units import G_MPS2
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import parse_slug

CAPTIONS: Final = "captions.json"
CURVE_COMPONENTS: Final = ("column_drift", "deck_displacement", "unseating", "column_shear")
CLOUD_DEMANDS: Final = ("column_drift_ratio", "column_shear_dcr", "deck_disp_m", "unseating_m")
AXIS_WORDS: Final = {"friction": "friction", "gap_mm": "the joint gap", "skew_deg": "skew"}
PERIODS_S: Final = np.geomspace(0.05, 5.0, 60)
PNG_DPI: Final = 150


@dataclass(frozen=True, slots=True, kw_only=True)
class Caption:
    """What the report says of a figure.

    Attributes:
        name: File name without ending.
        title: One line.
        text: What to see and how it was made.
    """

    name: str
    title: str
    text: str


type Drawing = tuple[Caption, Callable[[], Figure]]


def draw_study(*, tables: Mapping[str, Path], im_column: str, folder: Path) -> None:
    """Draw all figures of a study as SVG and PNG, and write their captions.

    Args:
        tables: Paths by name: demands, curves, effects, friction_pair, suite.
        im_column: Intensity measure of the fits.
        folder: Where the files go.
    """
    rows, curves, effects = (read_frame(tables[name]) for name in ("demands", "curves", "effects"))
    drawings = [
        *_table_drawings(rows, curves, effects, im_column),
        *_friction_pair_drawings(tables["friction_pair"]),
        *_motion_drawings(read_suite(tables["suite"])),
    ]
    folder.mkdir(parents=True, exist_ok=True)
    captions: list[Caption] = []
    for caption, draw in drawings:
        figure = draw()
        for ending in ("svg", "png"):
            figure.savefig(folder / f"{caption.name}.{ending}", dpi=PNG_DPI, bbox_inches="tight")
        plt.close(figure)
        captions.append(caption)
    text = json.dumps([asdict(caption) for caption in captions], indent=1)
    write_text(folder / CAPTIONS, text)


def read_captions(folder: Path) -> list[Caption]:
    """Return the captions of the figures in a folder, in their order."""
    return [Caption(**item) for item in json.loads((folder / CAPTIONS).read_text("utf-8"))]


def _table_drawings(
    demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame, im_column: str
) -> list[Drawing]:
    """Return the drawings of the tables, a set for each bridge and abutment model."""
    models = demands[["bridge", "abutment"]].drop_duplicates().itertuples(index=False)
    sets: list[Drawing] = []
    for bridge, abutment in sorted(models):
        own_demands, own_curves, own_effects = (
            table[(table["bridge"] == bridge) & (table["abutment"] == abutment)]
            for table in (demands, curves, effects)
        )
        sets += [
            (
                replace(
                    caption,
                    name=f"{bridge}_{ABUTMENTS[abutment].code}_{caption.name}",
                    title=f"{bridge}, {abutment.replace('_', '-')}: {caption.title}",
                ),
                draw,
            )
            for caption, draw in (
                *_effect_drawings(own_effects),
                *_fit_drawings(own_demands, own_curves, im_column),
            )
        ]
    return sets


def _effect_drawings(effects: pd.DataFrame) -> list[Drawing]:
    drawings: list[Drawing] = []
    for axis in ("friction", "gap_mm", "skew_deg"):
        part = effects[effects["axis"] == axis]
        if part.empty:
            continue
        words = AXIS_WORDS[axis]
        drawings.append(
            (
                Caption(
                    name=f"verdict_{axis}",
                    title=f"When does {words} matter?",
                    text="Geometric mean over motions of the demand ratio, each motion with "
                    "itself; negligible: the 90 % interval lies within 5 % of one.",
                ),
                lambda axis=axis: verdict_map(effects, axis),
            )
        )
        drawings.append(
            (
                Caption(
                    name=f"ratios_{axis}",
                    title=f"Paired effect of {words} with 90 % intervals",
                    text="Intervals by bootstrap over motions. The shaded band is 5 % either way. "
                    "Pairs in which a run collapsed are left out and counted in the table.",
                ),
                lambda axis=axis: paired_ratios(effects, axis),
            )
        )
    return drawings


def _fit_drawings(demands: pd.DataFrame, curves: pd.DataFrame, im_column: str) -> list[Drawing]:
    drawings: list[Drawing] = []
    for component in CURVE_COMPONENTS:
        part = curves[(curves["component"] == component) & (curves["status"] == "ok")]
        for method in ("cloud", "exceedance"):
            if part[part["method"] == method].empty:
                continue
            drawings.append(
                (
                    Caption(
                        name=f"curves_{component}_{method}",
                        title=f"Fragility of {component.replace('_', ' ')}, {method} fit",
                        text="Bands are 95 % of the fit; marks are the analyses. A limit state "
                        "that no analysis reached has no curve.",
                    ),
                    lambda component=component, method=method: fragility_curves(
                        curves, demands, component, method=method
                    ),
                )
            )
    drawings += [
        (
            Caption(
                name=f"cloud_{demand}",
                title=f"{label(demand)} against intensity",
                text="One mark per analysis; lines are the log-log regressions.",
            ),
            lambda demand=demand: demand_clouds(demands, curves, demand, im_column),
        )
        for demand in CLOUD_DEMANDS
    ]
    return drawings


def _friction_pair_drawings(path: Path) -> list[Drawing]:
    table = read_frame(path)
    if table.empty:
        return []
    runs: dict[str, pd.DataFrame] = {}
    where = ""
    for (slug, motion_id), rows in table.groupby(["variant", "motion_id"]):
        variant = parse_slug(str(slug))
        where = f"skew {variant.skew_deg} degrees, gap {variant.gap_mm} mm, motion {motion_id}"
        histories = rows.drop(columns=["variant", "motion_id"]).dropna(axis="columns", how="all")
        runs[f"friction {variant.friction:g}"] = histories.reset_index(drop=True)
    hysteresis = Caption(
        name="hysteresis",
        title=f"Abutments without and with friction: {where}",
        text="Force of each abutment on the deck (backwall, keys, pads) against the displacement "
        "of its deck end.",
    )
    displacement = Caption(
        name="displacement",
        title=f"Deck without and with friction: {where}",
        text="Displacement and rotation at the mass centre, relative to the ground.",
    )
    frequency = Caption(
        name="frequency",
        title=f"Frequency content without and with friction: {where}",
        text="Smoothed Fourier amplitudes of the deck and their ratio.",
    )
    return [
        (hysteresis, lambda: hysteresis_figure(runs)),
        (displacement, lambda: displacement_figure(runs)),
        (frequency, lambda: frequency_figure(runs)),
    ]


def _motion_drawings(suite: Sequence[SuiteMotion]) -> list[Drawing]:
    def draw() -> Figure:
        spectra = [
            motion.scale
            * pair_psa(
                motion.motion.accel_1_mps2,
                motion.motion.accel_2_mps2,
                motion.motion.dt_s,
                PERIODS_S,
            ).rotd50_mps2
            / G_MPS2
            for motion in suite
        ]
        return suite_spectra(np.array(spectra), PERIODS_S, title="Motions as applied (scaled)")

    caption = Caption(
        name="suite_spectra",
        title="Response spectra of the motions",
        text="RotD50, 5 % damping, scaled: one factor per motion, the same for all variants.",
    )
    return [(caption, draw)]
