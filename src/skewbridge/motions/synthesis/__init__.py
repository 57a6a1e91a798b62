"""Synthetic motions from a published stochastic model."""
