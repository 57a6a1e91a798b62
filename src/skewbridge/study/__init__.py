"""Studies: configuration, analyses of the variants, journals and results."""
