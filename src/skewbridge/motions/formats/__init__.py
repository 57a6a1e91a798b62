"""Room: motions/formats."""
