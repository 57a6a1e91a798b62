"""Bridges by name or file: those of the catalogue, drawings of the user, and scripts."""

from pathlib import Path

from skewbridge.bridge.catalogue import load_bridge, own_bridge_files
from skewbridge.bridge.frame import Structure
from skewbridge.bridge.script_files import script_files
from skewbridge.bridge.structures import CatalogueBridge


def is_script(name: str | Path) -> bool:
    """Return whether a bridge is the script of a user."""
    return Path(name).suffix == ".py"


def load_structure(name: str | Path) -> Structure:
    """Return the bridge of a name, file or script; an `InputError` names file, key and limit."""
    if is_script(name):
        # Imported here: pages and digests need bridges of the catalogue but not OpenSees.
        from skewbridge.bridge.script import load_script

        return load_script(Path(name))
    return CatalogueBridge(load_bridge(name))


def without_effect(name: str | Path) -> frozenset[str]:
    """Return the modelling options that do not act on a bridge."""
    structure = load_structure(name)
    return structure.ignored | structure.description.without_effect


def structure_files(name: str) -> list[Path]:
    """Return the files of a bridge that are outside the package."""
    if is_script(name):
        return script_files(Path(name).resolve())
    return own_bridge_files(name)
