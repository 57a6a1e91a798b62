"""Room: fragility."""
