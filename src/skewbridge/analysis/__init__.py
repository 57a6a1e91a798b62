"""Analyses of a model: modes, pushover, response history and recovery of failed steps."""
