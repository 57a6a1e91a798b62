  // ---- fragility curves ----
  const OUTSIDE = "fewer than three motions are as strong, or as weak";
  const isOutside = (fit, im) => (fit.im_low == null ? fit.extrapolated === true : im < fit.im_low || im > fit.im_high);
  const BANDS = 2; // largest number of curves with bands: more would hide each other
  const ofMethod = (fit, chosen) => (chosen.method === "preferred" ? fit.preferred : fit.method === chosen.method);
  const fitsOf = (chosen, shown) => {
    const [component, state] = chosen.state.split("/"), there = new Set(shown);
    return data.fits.filter((fit) => fit.component === component && fit.limit_state === state && ofMethod(fit, chosen) && there.has(fit.variant));
  };
  // smallest and largest demand of the complete analyses: the ends of the slider
  function reached(demand, shown) {
    const values = shown.flatMap((at) => rowsOf[at]).filter((row) => runs.complete[row] && runs.demands[demand][row] > 0).map((row) => runs.demands[demand][row]);
    return values.length ? [Math.min(...values), Math.max(...values)] : null;
  }
  function movedFit(fit, threshold) {
    return threshold === null ? fit : { theta: Math.exp((Math.log(threshold) - fit.ln_a) / fit.b), beta_total: Math.hypot(fit.sigma, fit.capacity_dispersion) / fit.b };
  }
  function thresholdOf(chosen, fits, ends) {
    const usable = ends !== null && fits.length > 0 && fits.every((fit) => fit.method === "cloud" && fit.sigma > 0 && fit.b > 0 && fit.knot === null && fit.growth === 0);
    pick("threshold-box").hidden = !usable;
    noEffect.threshold = usable ? "" : fits.some(isUnion) ? "threshold: these curves are unions of shear and flexure, so they have no line of their own" : fits.length ? "threshold: these curves are fitted to exceedances of the limit state only, without a line of demand against intensity" : "";
    if (!usable) return null;
    const own = fits[0].threshold, shown = demandIn(fits[0].demand, chosen.units);
    const [low, high] = ends.map(Math.log);
    const moved = chosen.threshold !== "" ? Math.exp(low + (high - low) * Math.min(1, Math.max(0, chosen.threshold / 1000))) : null;
    const place = moved === null ? 1000 * (Math.log(own) - low) / (high - low) : Number(chosen.threshold);
    pick("threshold").value = String(Math.round(Math.min(1000, Math.max(0, place))));
    pick("threshold-text").textContent = `${shown.label}: ${digits(shown.by * (moved ?? own))} ` + (moved === null ? "(the limit state)" : `(limit state: ${digits(shown.by * own)}; no band)`);
    pick("threshold-reset").hidden = moved === null;
    return moved;
  }
  function drawCurves(chosen) {
    const all = fitsOf(chosen, chosenVariants(chosen)), fits = all.slice(0, MOST), traces = [], entries = [];
    const shown = all.map((fit) => fit.variant), styles = lineStyles(shown.slice(0, MOST));
    const threshold = thresholdOf(chosen, all, all.length ? reached(all[0].demand, shown) : null);
    const [low, high] = [0.7 * data.im_range[0], 1.3 * data.im_range[1]];
    const grid = Array.from({ length: 120 }, (_, i) => low * (high / low) ** (i / 119));
    const bands = threshold === null && fits.length <= BANDS;
    const rows = () => all.flatMap((fit) => {
      const moved = movedFit(fit, threshold), band = threshold === null ? bandOf(fit) : null;
      return grid.map((im) => ({ variant: variants[fit.variant].name, component: fit.component, limit_state: fit.limit_state, method: fit.method, theta: moved.theta, beta: moved.beta_total, im, probability: exceedance(moved, im), low: band?.(im, -1), high: band?.(im, 1), extrapolated: isOutside(fit, im), theta_extrapolated: isOutside(fit, moved.theta) }));
    });
    const off = offNames();
    fits.forEach((fit) => {
      const moved = movedFit(fit, threshold), band = bandOf(fit), p = grid.map((im) => exceedance(moved, im));
      const name = variants[fit.variant].text, line = styles.get(fit.variant);
      entries.push({ name, line });
      if (off.has(name)) return;
      if (bands) [-1, 1].forEach((side) => traces.push({ x: grid, y: grid.map((im) => band(im, side)), mode: "lines", line: { width: 0 }, hoverinfo: "skip", ...(side > 0 ? { fill: "tonexty", fillcolor: line.color + "26" } : {}) }));
      traces.push({ x: grid, y: p, mode: "lines", name, line, text: grid.map((im) => isOutside(fit, im) ? " †" : ""), hovertemplate: `${name}<br>%{x:.3g}, P = %{y:.3f}%{text}<extra></extra>` });
    });
    legend(entries);
    const outside = all.filter((fit) => isOutside(fit, movedFit(fit, threshold).theta));
    const differing = all.filter((fit) => fit.methods_differ), changes = differing.map((fit) => fit.methods_ratio - 1);
    const percents = unique([Math.min(...changes), Math.max(...changes)].map((change) => signed(Math.round(100 * change), "%")));
    plot("plot", traces, { xaxis: logAxis(data.im, low, high), yaxis: plainAxis("P(exceeds | IM)", { range: [0, 1.01] }) });
    return { rows, notes: [
      !all.length && "No curve of this state for these variants and this method: see the list of states that no analysis reached, below the table.",
      outside.length > 0 && `The medians of ${outside.length} of ${all.length} curves are extrapolated: ${OUTSIDE}.`,
      differing.length > 0 && `The exceedance median differs from the cloud median in ${differing.length} of ${all.length} curves (${percents.join(" to ")}).`,
      all.length > MOST && `The first ${MOST} of ${all.length} curves are drawn: choose values of the axes; the CSV has all.`,
      threshold === null && all.length > BANDS && `Bands are drawn for at most ${BANDS} curves: choose values of the axes.`] };
  }
