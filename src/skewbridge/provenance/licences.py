"""The licences of installed packages, as their metadata state them."""

from importlib.metadata import PackageMetadata
from typing import Final

LONGEST: Final = 80  # characters of a licence that is given as text


def licence_of(found: PackageMetadata) -> str:
    """Return the licence of a package: its expression, else its classifiers, else its text."""
    classified = [
        text.rpartition(" :: ")[2]
        for text in found.get_all("Classifier") or []
        if text.startswith("License :: ") and text != "License :: OSI Approved"
    ]
    stated = (found.get("License") or "").strip().split("\n")[0]
    return (
        found.get("License-Expression") or ", ".join(classified) or stated[:LONGEST] or "not stated"
    )
