"""Verification studies, each with its comparisons, tables and figures."""
