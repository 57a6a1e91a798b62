"""Room: motions/synthesis, motions from a published stochastic model."""
