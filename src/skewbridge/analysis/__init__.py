"""Analyses of a built model: gravity, modes, pushover, and the response history with its recovery."""
