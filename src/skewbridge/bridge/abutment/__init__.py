"""Seat abutments: the ladder from `roller` to `contact_friction`, one interface."""
