"""Files: read within limits, checked, written atomically, with digests and provenance."""
