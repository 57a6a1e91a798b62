"""Room: bridge/abutment."""
