"""The bridges: one YAML file each, every number with its source, and their typed reading.

A user's own bridges stand in `config/bridges/`; see `skewbridge.bridge.catalogue.loading` for
the form.
"""

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.catalogue.loading import bridge_names, load_bridge, load_bridge_file

__all__ = ["BridgeData", "bridge_names", "load_bridge", "load_bridge_file"]
