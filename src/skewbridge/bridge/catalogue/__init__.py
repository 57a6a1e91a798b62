"""The catalogue of bridges: one YAML file each, every number with its source.

A user's own bridges are in `config/bridges/`; `skewbridge.bridge.catalogue.loading` describes the
format.
"""

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.catalogue.loading import bridge_names, load_bridge

__all__ = ["BridgeData", "bridge_names", "load_bridge"]
