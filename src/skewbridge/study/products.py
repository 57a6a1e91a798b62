"""Products of a study: digests of their sources and inputs, and whether a file is current."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from skewbridge.analysis.keys import bridge_digest
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.files.digests import (
    ENGINE,
    canonical,
    digest_of,
    engine_digest,
    layer_digests,
    opensees_version,
    provenance,
)
from skewbridge.files.tables import read_stamp
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig, load_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import motions_digest
from skewbridge.variant.grid import expand_grid

type MadeFrom = dict[str, str]

#: Keys of the configuration that influence no result.
_NO_RESULT: Final = {"results", "batches"}
_TABLES: Final = ("errors.py", "units.py", "files", "variant", "demands")
_ANALYSES: Final = (
    *ENGINE,
    "files",
    "demands",
    *(f"study/{name}.py" for name in ("analyses", "batch", "journal")),
)
_VERIFICATION: Final = (*ENGINE, "files", "motions", "demands/validity.py", "verification")
#: The figure of the modelling choices has their labels.
_SCREEN: Final = (
    *(*_TABLES, "motions", "fragility", "report"),
    *("study/config.py", "study/modelling_choices.py"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """Dependencies of the outputs of a rule.

    Attributes:
        sources: Packages and files of the package whose code makes them.
        sections: Keys of the configuration.
        after: Rules whose outputs it reads.
        inputs: Further inputs, see `_input_digests`; the motions count for all after another rule.
    """

    sources: tuple[str, ...]
    sections: tuple[str, ...] = ()
    after: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()


def _analyses(*sources: str, sections: tuple[str, ...], inputs: tuple[str, ...] = ()) -> Recipe:
    """Return the recipe of a rule that runs analyses, with what else it depends on."""
    return Recipe(
        sources=(*_ANALYSES, *sources),
        sections=("motions", "model", "uncertainty", "analysis", *sections),
        after=("prepare_motions",),
        inputs=("bridges", "opensees", *inputs),
    )


#: By rule, in the order in which one reads the other.
RECIPES: Final[Mapping[str, Recipe]] = {
    "prepare_motions": Recipe(
        sources=(*_TABLES[:-1], "motions", "study/inputs.py"),
        sections=("motions",),
        inputs=("motions", "periods"),
    ),
    "verify_contact": Recipe(sources=_VERIFICATION, inputs=("opensees",)),
    "verification": Recipe(
        sources=(
            *(*_VERIFICATION, "fragility", "report/run_figures.py"),
            *(f"study/{name}.py" for name in ("analyses", "batch", "inputs", "journal")),
        ),
        inputs=("opensees",),
    ),
    "analyse": _analyses(sections=("suspect",)),
    "plan_round": Recipe(
        sources=(
            *(*_ANALYSES, "fragility"),
            *(f"study/{name}.py" for name in ("progress", "rounds", "selection")),
        ),
        sections=("fragility",),
        after=("prepare_motions",),
        inputs=("variants", "limit_states", "bridges"),
    ),
    "analyse_round": _analyses("study/rounds.py", sections=("suspect",)),
    "collect_rounds": Recipe(sources=(*_TABLES, "fragility"), after=("plan_round",)),
    "collect_demands": Recipe(sources=_TABLES, after=("analyse",), inputs=("variants",)),
    "sensitivity": _analyses(
        "study/sensitivity.py", sections=("sensitivity",), inputs=("variants",)
    ),
    "modelling_choices": _analyses(
        "study/modelling_choices.py", sections=("grid", "modelling_choices")
    ),
    "friction_pair": Recipe(
        sources=(*_ANALYSES, "study/friction_pair.py"), after=("collect_demands",)
    ),
    "fit_fragility": Recipe(
        sources=(*_TABLES, "fragility", "report/checks.py"),
        sections=("fragility", "max_unfinished_share", "suspect"),
        after=("collect_demands",),
        inputs=("limit_states",),
    ),
    "check_predict": Recipe(
        sources=(*_ANALYSES, "fragility", "study/predict_check.py"),
        sections=("grid",),
        after=("fit_fragility",),
    ),
    "figures": Recipe(
        sources=_SCREEN, sections=("figures",), after=("friction_pair", "fit_fragility")
    ),
    "report": Recipe(
        sources=(*_SCREEN, "study/results.py"),
        sections=tuple(name for name in StudyConfig.model_fields if name not in _NO_RESULT),
        after=("verify_contact", "figures", "sensitivity"),
    ),
}


def made_from(study: StudyConfig) -> dict[str, MadeFrom]:
    """Return the digests of everything that the outputs of each rule depend on, by name.

    Equal digests mean equal outputs. They are parameters of the rules, so that Snakemake repeats
    the rules that changed, and are stored in the outputs. `InputError` for a wrong input.
    """
    inputs = _input_digests(study)
    sources = layer_digests({rule: recipe.sources for rule, recipe in RECIPES.items()})
    values = study.model_dump(mode="json")
    made: dict[str, MadeFrom] = {}
    for rule, recipe in RECIPES.items():
        made[rule] = {
            "sources": sources[rule],
            **{name: digest_of(canonical(values[name])) for name in recipe.sections},
            **{name: inputs[name] for name in recipe.inputs},
            **({"motions": inputs["motions"]} if recipe.after else {}),
            **{name: rule_digest(made[name]) for name in recipe.after},
        }
    return made


def _input_digests(study: StudyConfig) -> dict[str, str]:
    folder = StudyFolder(Path(study.results))
    periods = {name: load_bridge(name).t1_s for name in study.bridges_with_periods()}
    bridges = {Path(name).stem: bridge_digest(name) for name in study.grid.bridge}
    return {
        "motions": motions_digest(study, folder.motions_digest),
        "periods": digest_of(canonical(periods), periods[CONDITIONING_BRIDGE]),
        "bridges": digest_of(canonical(bridges)),
        "opensees": opensees_version(),
        "variants": digest_of(*sorted(variant.slug for variant in expand_grid(study.grid))),
        "limit_states": digest_of(load_limit_states(Path(study.fragility.limit_states))),
    }


def rule_digest(made: Mapping[str, str]) -> str:
    """Return the digest of all dependencies of the outputs of a rule."""
    return digest_of(canonical(made))


def stamp_of(rule: str, made: Mapping[str, str], study: StudyConfig) -> dict[str, str]:
    """Return the provenance of the outputs of a rule made from these digests, by name."""
    values = study.model_dump(mode="json", exclude=_NO_RESULT)
    return provenance(
        rule=rule,
        rule_digest=rule_digest(made),
        config_digest=digest_of(canonical(values)),
        suite_digest=made.get("motions", "none"),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Provenance recorded in a file, that which it would have now, and whether it is current."""

    recorded: dict[str, str]
    now: dict[str, str]
    is_current: bool

    @property
    def differences(self) -> list[str]:
        """Names of the entries that differ now."""
        return [name for name, value in self.now.items() if self.recorded.get(name) != value]


def origin_of(path: Path, config: Path, base: Path | None = None) -> Origin:
    """Return the provenance of a file of a study or of ``skewbridge run``: is it still current?

    A product of the workflow is current if its rule would make it from the same sources, motions
    and sections of the configuration; what its rule does not use may differ. A result of
    ``skewbridge run`` is current if the sources of an analysis and OpenSees are the same.

    Raises:
        InputError: The file has no provenance, or the configuration is bad.
    """
    recorded = read_stamp(path)
    now = {name: value for name, value in provenance().items() if name in recorded}
    decisive = ["openseespy_version"]
    if "rule" in recorded:
        study = load_config(config, base=base)
        made: MadeFrom = made_from(study).get(recorded["rule"], {"motions": "unknown"})
        present = stamp_of(recorded["rule"], made, study)
        now |= {name: present[name] for name in ("rule_digest", "config_digest", "suite_digest")}
        decisive = ["rule_digest"]
    elif "engine_digest" in recorded:
        now["engine_digest"] = engine_digest()
        decisive += ["engine_digest"]
    else:
        raise InputError(
            f"{path} records package versions but no digest of the sources: it was written "
            "before results recorded one",
            file=str(path),
        )
    is_current = all(recorded.get(name) == now[name] for name in decisive)
    return Origin(recorded=recorded, now=now, is_current=is_current)
