"""Bridges and abutments: catalogue, sections, and the model in the OpenSees domain."""
