"""The tables of a study: curves, effects, factors, systems, from its demands."""
