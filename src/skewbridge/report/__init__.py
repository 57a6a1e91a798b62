"""Figures, drawn from the tables of a study, and the report."""
