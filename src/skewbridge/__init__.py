"""Seismic fragility of bridges with seat-type abutments: skew, joint gap and contact-friction."""
