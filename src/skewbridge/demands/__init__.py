"""Room: demands."""
