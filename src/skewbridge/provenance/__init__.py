"""Digests of sources and inputs: what must be computed again, and what need not."""
