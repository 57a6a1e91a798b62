"""Bridge variants: axes, abutment models, modelling options, names and the grid of a study."""
