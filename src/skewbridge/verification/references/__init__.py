"""Solvers, closed forms and cases that the studies compare with."""
