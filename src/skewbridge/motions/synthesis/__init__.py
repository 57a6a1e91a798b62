"""Motions from a published stochastic model."""
