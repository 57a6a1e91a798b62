  // ---- the normal distribution ----
  // the error function by the rational forms of W. J. Cody (1969), Math. Comp. 23:631-637
  function erfc(x) {
    const a = Math.abs(x);
    const at = (coefficients, y) => coefficients.reduce((sum, value) => sum * y + value, 0);
    let r;
    if (a < 0.5) {
      const n = [1.85777706184603153e-1, 3.16112374387056560, 1.13864154151050156e2, 3.77485237685302021e2, 3.20937758913846947e3];
      const d = [1, 2.36012909523441209e1, 2.44024637934444173e2, 1.28261652607737228e3, 2.84423683343917062e3];
      r = 1 - a * at(n, a * a) / at(d, a * a);
    } else if (a < 4) {
      const n = [2.15311535474403846e-8, 5.64188496988670089e-1, 8.88314979438837594, 6.61191906371416295e1, 2.98635138197400131e2, 8.81952221241769090e2, 1.71204761263407058e3, 2.05107837782607147e3, 1.23033935479799725e3];
      const d = [1, 1.57449261107098347e1, 1.17693950891312499e2, 5.37181101862009858e2, 1.62138957456669019e3, 3.29079923573345963e3, 4.36261909014324716e3, 3.43936767414372164e3, 1.23033935480374942e3];
      r = Math.exp(-a * a) * at(n, a) / at(d, a);
    } else {
      const y = 1 / (a * a);
      const n = [1.63153871373020978e-2, 3.05326634961232344e-1, 3.60344899949804439e-1, 1.25781726111229246e-1, 1.60837851487422766e-2, 6.58749161529837803e-4];
      const d = [1, 2.56852019228982242, 1.87295284992346047, 5.27905102951428412e-1, 6.05183413124413191e-2, 2.33520497626869185e-3];
      r = Math.exp(-a * a) / a * (1 / Math.sqrt(Math.PI) - y * at(n, y) / at(d, y));
    }
    return x < 0 ? 2 - r : r;
  }
  const phi = (z) => 0.5 * erfc(-z / Math.SQRT2);
  function quantile(p) {
    let low = -9, high = 9;
    for (let i = 0; i < 80; i++) { const middle = (low + high) / 2; if (phi(middle) < p) low = middle; else high = middle; }
    return low;
  }
  const probability = (im, theta, beta) => phi(Math.log(im / theta) / beta);
  // bivariate normal distribution: integral over the correlation (Plackett 1954), by Simpson's rule
  function bothBelow(u, v, rho) {
    const n = 200, step = Math.asin(Math.max(-1, Math.min(1, rho))) / n;
    let sum = 0;
    for (let i = 0; i <= n; i++) {
      const s = Math.sin(i * step), c = Math.max(1e-12, 1 - s * s);
      sum += (i === 0 || i === n ? 1 : i % 2 ? 4 : 2) * Math.exp((2 * u * v * s - u * u - v * v) / (2 * c));
    }
    return phi(u) * phi(v) + sum * step / (6 * Math.PI);
  }
  // the curve of a fit: lognormal, or the union of shear and flexure
  const isUnion = (fit) => fit.theta_shear != null && fit.theta_flexure != null;
  function exceedance(fit, im) {
    if (!isUnion(fit)) return probability(im, fit.theta, fit.beta_total);
    const u = Math.log(im / fit.theta_shear) / fit.beta_shear, v = Math.log(im / fit.theta_flexure) / fit.beta_flexure;
    return Math.min(1, Math.max(phi(u), phi(v), phi(u) + phi(v) - bothBelow(u, v, fit.mode_correlation)));
  }
  // the pointwise band: Wald on ln(im/theta)/beta, then phi; the dispersion of the capacity is known
  function bandOf(fit) {
    const beta = fit.beta_total, slope = fit.beta / beta, reach = quantile(0.5 + fit.level / 2);
    return (im, side) => {
      const eta = isUnion(fit) ? quantile(exceedance(fit, im)) : Math.log(im / fit.theta) / beta;
      const variance = fit.var_ln_theta + 2 * eta * fit.cov_ln_theta_beta * slope + eta * eta * fit.var_beta * slope * slope;
      return phi(eta + side * reach * Math.sqrt(Math.max(0, variance)) / beta);
    };
  }
