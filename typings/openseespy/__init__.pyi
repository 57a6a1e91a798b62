"""OpenSeesPy."""
