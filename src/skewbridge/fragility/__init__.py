"""Fragility statistics: fits with stated status and interval, paired effects, exchange."""
