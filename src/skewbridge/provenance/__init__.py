"""Provenance of results: digests of sources and inputs, versions, atomic files."""
