"""Ground motions: readers, intensity measures, synthesis, scaling, suites."""
