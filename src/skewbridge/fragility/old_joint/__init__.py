"""One model over the axes of a study: median and dispersion as functions of skew, gap, friction."""
