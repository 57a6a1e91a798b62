"""Plans of the rounds of a study that runs until its effects are decided, and their files."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from skewbridge.files.text import read_json
from skewbridge.study.analyses import StudySetup
from skewbridge.study.folder import StudyFolder

#: Environment variable with the time at which the command began and its processors (rounds.smk).
CLOCK: Final = "SKEWBRIDGE_CLOCK"
#: Reasons for which a study ends.
ALL_DECIDED: Final = "decided"
OUT_OF_REACH: Final = "most"
OUT_OF_TIME: Final = "hours"


def round_line(plan: Mapping[str, Any]) -> str:
    """Return the line about a round: what is decided, and what comes next."""
    start, cells = f"round {plan['round']}: ", len(plan["cells"])
    if cells:
        start += f"{plan['decided']} of {cells} decided; "
    if plan["ended"] is None:
        minutes = max(round(plan["forecast_s"] / 60), 1)
        return f"{start}next {plan['analyses']} analyses, about {minutes} min"
    left = cells - plan["decided"]
    reasons = {
        ALL_DECIDED: "the question is answered",
        OUT_OF_REACH: f"{left} are out of reach of the largest number of motions (design.most)",
        OUT_OF_TIME: f"the time is used up (design.hours {plan['hours']:g}): "
        "a larger value resumes",
    }
    return start + reasons[plan["ended"]]


def tables_of_round(folder: StudyFolder, plan: Path) -> list[Path]:
    """Return the demands that a round makes; none where the study ends with this plan."""
    content = read_json(plan)
    changed = [slug for slug, (start, end) in content["motions"].items() if end > start]
    return [folder.round_demands(content["round"], slug) for slug in changed]


def limit_of_round(plan: Path, hours: float) -> float:
    """Return the time limit with which the plan of a round is or must be made.

    A plan keeps its limit, unless it ended the study for lack of time and there is more now. As a
    parameter of the checkpoint, the limit makes Snakemake plan such a round again.
    """
    if not plan.is_file():
        return hours
    made = read_json(plan)
    return max(made["hours"], hours) if made["ended"] == OUT_OF_TIME else made["hours"]


def setup_of_round(setup: StudySetup, plan: Path, slug: str) -> StudySetup:
    """Return the setup of a study with the motions of one variant in a round."""
    start, end = read_json(plan)["motions"][slug]
    names = setup.motion_ids[start:end]
    return replace(setup, suite=tuple(m for m in setup.suite if m.motion.motion_id in names))
