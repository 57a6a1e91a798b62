"""One reader per file format, behind `skewbridge.motions.read`."""
