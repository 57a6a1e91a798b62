"""Figures (tables in, figure out) and the report."""
