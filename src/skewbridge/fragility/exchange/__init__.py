"""Files from and for other tools."""
