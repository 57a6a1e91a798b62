"""Probability that any of several correlated normal variables is below its limit.

References:
    Plackett (1954), Biometrika 41(3/4):351-360, for the bivariate normal integral.
    Genz (1992), J. Comput. Graph. Stat. 1(2):141-149, for more variables.
    Sloan and Reztsov (2002), Math. Comp. 71(237):263-273, for the choice of a lattice component by
    component; Hickernell (2002), MCQMC 2000, 274-289, for the tent transform, with which its error
    falls with the square of the points.
"""

from functools import lru_cache
from typing import Final

import numpy as np
from scipy import special

from skewbridge.fragility.old_likelihood.links import FloatArray

#: Of the lattice for three or more components: error 3e-6 (root mean square) in systems of studies.
POINTS: Final = 1021
#: Of that of bootstrap replicates, whose errors (2e-4) are common and small beside their scatter.
FEW_POINTS: Final = 67
_CHUNK: Final = 400_000  # numbers held at once: they stay in the cache
_NEGLIGIBLE: Final = 1e-6  # probability below the error of the lattice
_JITTER: Final = 1e-10  # makes a singular correlation (equal components) factorisable
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


def bivariate_upper(h: FloatArray, k: FloatArray, rho: float) -> FloatArray:
    """Return P(Z1 <= h, Z2 <= k) of a standard bivariate normal, by Plackett's integral."""
    top = float(np.arcsin(np.clip(rho, -1.0, 1.0)))
    angle = 0.5 * top * (_NODES + 1.0)
    sine, square = np.sin(angle), np.maximum(np.cos(angle) ** 2, 1e-300)
    exponent = -(h[:, None] ** 2 - 2.0 * h[:, None] * k[:, None] * sine + k[:, None] ** 2)
    integral = np.exp(exponent / (2.0 * square)) @ _WEIGHTS * 0.5 * top
    return special.ndtr(h) * special.ndtr(k) + integral / (2.0 * np.pi)


def union(z: FloatArray, correlation: FloatArray) -> FloatArray:
    """Return P(any Z_i <= z_i) of rows of z, shape (n, m), with one correlation."""
    m = z.shape[1]
    if m == 1:
        return np.asarray(special.ndtr(z[:, 0]))
    if m == 2:
        return 1.0 - bivariate_upper(-z[:, 0], -z[:, 1], float(correlation[0, 1]))
    return union_of_each(z, np.broadcast_to(correlation, (z.shape[0], m, m)), POINTS)


def union_of_each(z: FloatArray, correlation: FloatArray, points: int) -> FloatArray:
    """Return P(any Z_i <= z_i) of rows of z, shape (n, m), each with its own correlation."""
    order = np.argsort(-z, axis=1)  # the most restrictive first: less variance
    top = np.take_along_axis(z, order, axis=1)
    p = special.ndtr(top[:, 0])
    # what adds less than `_NEGLIGIBLE` is left out: components, and all beside one that is certain
    counts = np.where(p < 1.0 - _NEGLIGIBLE, np.sum(special.ndtr(top) > _NEGLIGIBLE, axis=1), 1)
    for count in np.unique(counts[counts > 1]):
        rows = np.flatnonzero(counts == count)
        for part in np.array_split(rows, 1 + rows.size * points * count // _CHUNK):
            own = order[part, :count]
            matrix = correlation[part[:, None, None], own[:, :, None], own[:, None, :]]
            p[part] = 1.0 - _all_below(-top[part, :count], matrix, points)
    return p


def _all_below(limit: FloatArray, correlation: FloatArray, points: int) -> FloatArray:
    """Return P(Z_i <= limit_i for all i) of each row by Genz's separation of variables."""
    n, m = limit.shape
    root = np.linalg.cholesky(correlation + _JITTER * np.eye(m))
    lattice = _lattice(m - 1, points)
    e = np.repeat(special.ndtr(limit[:, :1] / root[:, :1, 0]), points, axis=1)
    product = e.copy()
    y = np.zeros((n, m - 1, points))
    for i in range(1, m):
        e *= lattice[i - 1]
        special.ndtri(np.clip(e, 1e-300, 1.0 - 1e-16, out=e), out=y[:, i - 1])
        inner = (root[:, i, None, :i] @ y[:, :i])[:, 0]
        np.subtract(limit[:, i, None], inner, out=inner)
        inner /= root[:, i, i, None]
        special.ndtr(inner, out=e)
        product *= e
    return np.mean(product, axis=1)


@lru_cache(maxsize=64)
def _lattice(size: int, points: int) -> FloatArray:
    """Return a shifted lattice with the tent transform, shape (size, points).

    The shift of a quarter of a point keeps off 0 and 1, the limits of the variables, at which
    equal components are undecided.
    """
    turns = np.outer(_generator(size, points), np.arange(points)) / points
    return 1.0 - np.abs(2.0 * ((turns + 0.25 / points) % 1.0) - 1.0)


@lru_cache(maxsize=64)
def _generator(size: int, points: int) -> tuple[int, ...]:
    """Return the generating vector for a prime number of points, one component after another.

    Each makes the worst-case error for smooth periodic functions least, with weights 1/j^2 of the
    variables: the first, most restrictive ones matter most.
    """
    if size == 0:
        return ()
    before = _generator(size - 1, points)
    numbers = np.arange(points)
    x = numbers / points
    bernoulli = 2.0 * np.pi**2 * (x * x - x + 1.0 / 6.0)
    product = np.ones(points)
    for place, z in enumerate(before, start=1):
        product *= 1.0 + bernoulli[numbers * z % points] / place**2
    tried = np.arange(1, points // 2 + 1)
    errors = bernoulli[np.outer(tried, numbers) % points] @ product
    # equal errors differ by rounding: the first of them, on any machine
    return (*before, int(tried[errors < np.min(errors) + 1e-9][0]))
