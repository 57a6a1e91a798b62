"""Log-likelihoods, their maxima, intervals and the result of a fit."""
