"""The studies of the paper, each with its comparisons, tables and figures."""
