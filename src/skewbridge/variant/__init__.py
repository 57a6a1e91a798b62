"""One bridge variant: its axes, its name, the grid of a study."""
