"""What must be computed again, and what need not: digests of sources, whole files, versions."""
