  // ---- the analyses: demand against intensity ----
  function drawAnalyses(chosen) {
    const all = chosenVariants(chosen), shown = all.slice(0, MOST), styles = lineStyles(shown), traces = [], entries = [];
    const demand = chosen.demand, { by, label } = demandIn(demand, chosen.units), values = runs.demands[demand];
    const rows = () => all.flatMap((at) => rowsOf[at].map((row) => ({ variant: variants[at].name, motion_id: data.motions[runs.motion[row]], scale: runs.scale[row], status: data.statuses[runs.status[row]], complete: runs.complete[row], run_key: runs.key[row], [data.im_name]: runs.im[row], [demand]: values[row] })));
    const off = offNames();
    shown.forEach((at) => {
      const name = variants[at].text, { color, dash } = styles.get(at), own = rowsOf[at].filter((row) => values[row] > 0);
      entries.push({ name, line: styles.get(at) });
      if (off.has(name)) return;
      traces.push({ x: own.map((row) => runs.im[row]), y: own.map((row) => by * values[row]), mode: "markers", customdata: own.map((row) => [row]),
        text: own.map((row) => `${name}<br>${loadingText(row)}`), hovertemplate: "%{text}<br>%{x:.3g}, %{y:.4g}<extra></extra>",
        marker: { color, symbol: own.map((row) => (runs.complete[row] ? "circle" : "triangle-up-open")), size: 7, opacity: 0.75 } });
      const fit = data.fits.find((each) => each.variant === at && each.demand === demand && each.b !== null);
      const ims = own.map((row) => runs.im[row]);
      if (fit && ims.length) {
        const ends = [Math.min(...ims), Math.max(...ims)], inside = fit.knot > ends[0] && fit.knot < ends[1];
        if (inside) ends.splice(1, 0, fit.knot);
        traces.push({ x: ends, y: ends.map((im) => by * Math.exp(fit.ln_a) * im ** fit.b * (fit.knot === null ? 1 : Math.max(im / fit.knot, 1) ** (fit.b_above - fit.b))), mode: "lines", line: { color, dash, width: 1.4 }, hoverinfo: "skip" });
      }
    });
    legend(entries);
    const marks = traces.flatMap((trace) => trace.y), seen = marks.length ? [Math.min(...marks), Math.max(...marks)] : [1, 10];
    const limits = unique(data.fits.filter((fit) => fit.demand === demand).map((fit) => fit.limit_state + "/" + fit.threshold)).map((text) => text.split("/"));
    const shapes = limits.map(([, limit]) => ({ type: "line", xref: "paper", x0: 0, x1: 1, y0: by * limit, y1: by * limit, line: { color: "#6b7378", width: 1, dash: "dot" } }));
    const annotations = limits.map(([state, limit]) => ({ xref: "paper", x: 0.01, xanchor: "left", y: Math.log10(by * limit), yanchor: "bottom", text: words(state), showarrow: false, font: { size: 11, color: "#4a545c" } }));
    plot("plot", traces, { xaxis: logAxis(data.im, ...data.im_range), yaxis: logAxis(label, ...seen), shapes, annotations }, showCommands);
    const own = all.flatMap((at) => rowsOf[at]), open = own.some((row) => !runs.complete[row]), none = own.filter((row) => !(values[row] > 0)).length;
    return { rows, notes: [
      "Choose a point: the command that repeats its analysis appears below the picture.",
      open && "Open triangles: a column failed or the analysis ended early, so the demand is a lower bound.",
      none > 0 && `${none} analyses have a demand of zero and no mark.`,
      all.length > MOST && `The first ${MOST} of ${all.length} variants are drawn: choose values of the axes; the CSV has all.`] };
  }
