"""Fragility statistics: curve fits with status and interval, paired effects, exports."""
