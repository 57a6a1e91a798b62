"""Verification against closed forms and other references, and of statements of the paper."""
