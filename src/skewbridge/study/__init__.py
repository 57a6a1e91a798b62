"""The study: typed configuration, variants of the grid, provenance."""
