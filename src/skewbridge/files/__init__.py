"""Read files within size limits, check them, write them atomically; digests and provenance."""
