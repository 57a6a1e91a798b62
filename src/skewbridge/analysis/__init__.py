"""Analyses of a built model: gravity, modes, pushover, response history and its recovery."""
