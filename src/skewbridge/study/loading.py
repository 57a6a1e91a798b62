"""Reading the configuration: YAML in, typed sections out."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skewbridge.reading import checked, merged, read_mapping
from skewbridge.study.config import StudyConfig


def parse_config(raw: Mapping[str, Any]) -> StudyConfig:
    """Return the validated configuration.

    Args:
        raw: The mapping as Snakemake or YAML gives it; a section left out has its defaults.

    Raises:
        InputError: A key is unknown or a value is outside its limits; every finding is one line
            with the key, the limit and the value given.
    """
    return checked(StudyConfig, dict(raw), "the configuration")


def load_config(path: Path, base: Path | None = None) -> StudyConfig:
    """Read a configuration file, merged over a base file as Snakemake merges ``--configfile``.

    Raises:
        InputError: The file is missing, no YAML mapping, or invalid.
    """
    raw = read_mapping(base) if base is not None and base != path else {}
    return checked(StudyConfig, merged(raw, read_mapping(path)), path)


def plain_sections(config: StudyConfig, *names: str) -> dict[str, Any]:
    """Return sections as plain values, fit for `params` of a rule and for `parse_config`."""
    return config.model_dump(mode="json", include=set(names))
