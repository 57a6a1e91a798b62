"""The list of analyses of a study, and its parts: what one job of the workflow analyses.

A part is a run of analyses in the order of the list: small variants together, a large one cut into
blocks of motions. Which they are follows from the list and from the number of parts alone, and the
list is made once, before the analyses; so a job on another machine finds the same part.
"""

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from skewbridge.provenance.files import write_text
from skewbridge.study.costs import forecast_cpu_s
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import read_content
from skewbridge.study.keys import run_key
from skewbridge.study.progress import study_state
from skewbridge.study.setup import StudySetup

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """One analysis of the list.

    Attributes:
        variant: Name of its variant.
        number: Its place among the analyses of the variant.
        run_key: Its key.
        cpu_s: Processor time by forecast; 0 if it was done when the list was made.
    """

    variant: str
    number: int
    run_key: str
    cpu_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """All analyses of a study.

    Attributes:
        sections: ``motions``, ``model`` and ``analysis`` of the configuration.
        analyses: The analyses, variant by variant. An IDA does not know them beforehand: it has
            the first one of every search.
    """

    sections: Mapping[str, Any]
    analyses: Sequence[Planned]

    @classmethod
    def read(cls, path: Path) -> Self:
        """Return the plan that `write_plan` wrote."""
        found = json.loads(path.read_text(encoding="utf-8"))
        return cls(
            sections=found["sections"], analyses=[Planned(**each) for each in found["analyses"]]
        )

    def keys(self) -> dict[str, list[str]]:
        """Return the keys of the analyses by variant."""
        return keys_by_variant(self.analyses)

    def part(self, number: int, count: int) -> list[Planned]:
        """Return one of so many parts of about the same cost, the longest analyses first.

        Args:
            number: Which one, from 1.
            count: Number of parts.
        """
        total_s = sum(each.cpu_s for each in self.analyses)
        before_s = 0.0
        chosen: list[Planned] = []
        for each in self.analyses:
            middle_s = before_s + each.cpu_s / 2.0
            before_s += each.cpu_s
            share = middle_s / total_s if total_s > 0.0 else 0.0
            if min(int(share * count), count - 1) == number - 1:
                chosen.append(each)
        return sorted(chosen, key=lambda each: -each.cpu_s)


def keys_by_variant(analyses: Sequence[Planned]) -> dict[str, list[str]]:
    """Return the keys of planned analyses by variant."""
    keys: dict[str, list[str]] = {}
    for each in analyses:
        keys.setdefault(each.variant, []).append(each.run_key)
    return keys


def planned_keys(folder: StudyFolder) -> dict[str, list[str]]:
    """Return the keys of all analyses of the study by variant.

    Empty before there is a plan, or with that of another version of the program.
    """
    if not folder.plan.exists():
        return {}
    try:
        return Plan.read(folder.plan).keys()
    except (KeyError, TypeError):
        return {}


def write_plan(setup: StudySetup, variants: Sequence[str], sections: Mapping[str, Any]) -> None:
    """Write the list of analyses with their forecast, and say how many are done.

    Args:
        setup: What the variants share.
        variants: Their names.
        sections: What the setup was made from.
    """
    content = read_content(setup.folder.journals)
    places = [(slug, n, task) for slug in variants for n, task in enumerate(setup.tasks(slug))]
    tasks = [task for _, _, task in places]
    keys = [run_key(task) for task in tasks]
    plan = Plan(
        sections=sections,
        analyses=[
            Planned(variant=slug, number=number, run_key=key, cpu_s=cpu_s)
            for (slug, number, _), key, cpu_s in zip(
                places, keys, forecast_cpu_s(tasks, keys, content.rows), strict=True
            )
        ],
    )
    write_text(setup.folder.plan, json.dumps(asdict(plan), indent=1))
    state = study_state(plan.keys(), content)
    logger.info(
        "%d variants, %d analyses, %d of them done", state.variants, state.analyses, state.done
    )
    for note in state.notes:
        logger.warning(note)
