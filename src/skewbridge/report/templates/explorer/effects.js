  // ---- effects: forest plot, verdict grid and the pairs behind a cell ----
  const REACH = [0.4, 2.5]; // ends of the axis of ratios; arrows mark values outside
  const effectCsv = (effect, factor) => ({ bridge_abutment: data.models[effect.model], quantity: effect.quantity, demand: effect.demand, axis: effect.axis, from_value: effect.from, to_value: effect.to, ...Object.fromEntries(data.axes.map((axis, place) => [axis.name, effect.values?.[place]])), judged_by: effect.judged_by, unit: effect.judged_by === RATIO ? "" : effect.unit, value: effect.value, low: effect.low, high: effect.high, margin: factor * effect.margin, n_motions: effect.n_motions, verdict: data.styles[styleOf(effect, factor)].verdict });
  const groupName = (effect, units) => shownUnit(effect, units).unit;

  function drawForest(chosen) {
    const factor = Number(chosen.margin), units = chosen.units;
    const all = chosenEffects(chosen).filter((effect) => effect.change === chosen.change && (!effect.values || effect.demand === (chosen.quantity === "demand" ? chosen.demand : chosen.state)));
    const lines = all.slice(0, 2 * MOST);
    const groups = unique(lines.map((effect) => groupName(effect, units))).map((unit) => ({ unit, own: lines.filter((effect) => groupName(effect, units) === unit) }));
    const traces = [], layout = { shapes: [] }, narrow = pick("plot").parentElement.clientWidth < 600;
    const room = lines.length + 3 * groups.length;
    let top = 1;
    groups.forEach(({ unit, own }, g) => {
      const ratio = unit === "%", bottom = top - own.length / room, suffix = g ? String(g + 1) : "";
      const { by } = shownUnit(own[0], units), at = (effect, value) => (value === null ? null : ratio ? value : by * value);
      const ends = own.flatMap((effect) => [at(effect, effect.low), at(effect, effect.value), at(effect, effect.high)]).filter((value) => value !== null && Number.isFinite(value));
      const widest = own.map((effect) => marginsOf(effect, factor)).map((pair) => (ratio ? pair.map(Math.exp) : pair.map((value) => by * value)));
      const reach = [Math.min(...ends, ...widest.map(([low]) => low)), Math.max(...ends, ...widest.map(([, high]) => high))];
      const range = ratio ? [Math.max(REACH[0], reach[0] / 1.03), Math.min(REACH[1], reach[1] * 1.03)] : [reach[0] - 0.04 * (reach[1] - reach[0]), reach[1] + 0.04 * (reach[1] - reach[0])];
      const inside = (value) => Math.min(range[1], Math.max(range[0], value));
      const axes = { xaxis: "x" + suffix, yaxis: "y" + suffix }, styles = own.map((effect) => data.styles[styleOf(effect, factor)]);
      const values = own.map((effect) => at(effect, effect.value)), known = own.map((_, y) => y).filter((y) => values[y] !== null);
      const bands = unique(widest.map(String)).length > 1 ? widest.map((pair, y) => [pair, y - 0.5, y + 0.5]) : [[widest[0], -0.5, own.length - 0.5]];
      bands.forEach(([[below, above], y0, y1]) => layout.shapes.push({ type: "rect", xref: "x" + suffix, yref: "y" + suffix, x0: inside(below), x1: inside(above), y0, y1, fillcolor: "#e9edf0", line: { width: 0 }, layer: "below" }));
      const drawn = known.filter((y) => own[y].low !== null && own[y].high !== null);
      traces.push({ ...axes, x: drawn.flatMap((y) => [inside(at(own[y], own[y].low)), inside(at(own[y], own[y].high)), null]), y: drawn.flatMap((y) => [y, y, null]), mode: "lines", line: { color: "#39434a", width: 2 }, hoverinfo: "skip" });
      const text = (y) => `${nameOf(own[y])}${own[y].values ? ", " + placeText(own[y]) : ""}<br>${styles[y].sign} ${changeText(own[y], units)} (${intervalText(own[y], units)})<br>${styles[y].text}`;
      traces.push({ ...axes, x: known.map((y) => inside(values[y])), y: known, mode: "markers", text: known.map(text), hovertemplate: "%{text}<extra></extra>", customdata: known.map((y) => own[y].id),
        marker: { symbol: known.map((y) => (values[y] > range[1] ? "triangle-right" : values[y] < range[0] ? "triangle-left" : "circle")), size: 10, color: known.map((y) => styles[y].fill), line: { color: "#39434a", width: 1.2 } } });
      traces.push({ ...axes, x: known.map(() => range[1]), y: known, mode: "text", textposition: "middle right", cliponaxis: false, hoverinfo: "skip", textfont: { size: 12 }, text: known.map((y) => (narrow ? changeText(own[y], units) : `${styles[y].sign} ${changeText(own[y], units)} (${intervalText(own[y], units)})`)) });
      layout["xaxis" + suffix] = { domain: [0, 1], anchor: "y" + suffix, gridcolor: "#e4e8ea", zeroline: false, ticks: "outside", tickangle: 0, nticks: narrow ? 3 : 8, ...(ratio ? { type: "log", range: range.map(Math.log10), ...percentTicks(range, narrow ? 4 : 10) } : { range, ticksuffix: " " + unit }) };
      const label = (effect) => (effect.values ? placeText(effect) : nameOf(effect));
      layout["yaxis" + suffix] = { domain: [Math.max(0, bottom), top], anchor: "x" + suffix, range: [own.length - 0.5, -0.5], tickmode: "array", tickvals: own.map((_, y) => y), ticktext: own.map(label), showgrid: false, zeroline: false, automargin: true, tickfont: { size: narrow ? 10 : 12 } };
      layout.shapes.push({ type: "line", xref: "x" + suffix, yref: "y" + suffix, x0: ratio ? 1 : 0, x1: ratio ? 1 : 0, y0: -0.5, y1: own.length - 0.5, line: { color: "#6b7378", width: 1 } });
      top = bottom - 3 / room;
    });
    legend([]);
    plot("plot", traces, { ...layout, height: 40 + 24 * room, margin: { l: 10, r: narrow ? 72 : 210, t: 6, b: 30 } }, openCell);
    return { rows: () => all.map((effect) => effectCsv(effect, factor)), notes: [
      !all.length && "This model has no effect of this change on this demand: choose a different change.",
      all.length > lines.length && `The first ${lines.length} of ${all.length} effects are drawn: choose values of the axes; the CSV has all.`] };
  }

  function drawGrid(chosen) {
    const factor = Number(chosen.margin), effects = chosenEffects(chosen);
    const title = (effect) => effect.change + (effect.values ? ", " + placeText(effect) : "");
    const columns = unique(effects.map(title)), shown = columns.slice(0, MOST);
    const table = element("table", "", { class: "map" }), head = table.createTHead().insertRow(), body = table.createTBody();
    head.append(element("td", ""), ...shown.map((name) => element("th", name, { scope: "col" })));
    const drawn = new Set(shown), cells = new Map(effects.filter((effect) => drawn.has(title(effect))).map((effect) => [effect.demand + "/" + title(effect), effect]));
    unique(effects.map((effect) => effect.demand)).forEach((demand) => {
      const line = body.insertRow();
      line.append(element("th", nameOf(effects.find((effect) => effect.demand === demand)), { scope: "row" }));
      shown.forEach((name) => {
        const effect = cells.get(demand + "/" + name), cell = line.insertCell();
        if (!effect) { cell.textContent = "–"; return; }
        const style = styleOf(effect, factor), button = element("button", `${data.styles[style].sign} ${changeText(effect, chosen.units)}`, { type: "button", "data-effect": effect.id, "aria-pressed": String(String(effect.id) === chosen.cell) });
        button.append(element("small", intervalText(effect, chosen.units)));
        button.addEventListener("click", () => openCell(effect.id));
        cell.className = style;
        cell.append(button);
      });
    });
    pick("rows").replaceChildren(table);
    pick("rows").hidden = false;
    return { rows: () => effects.map((effect) => effectCsv(effect, factor)), notes: [
      chosen.quantity === "demand" && "Choose a cell: its pairs of analyses are drawn below, motion by motion.",
      columns.length > MOST && `The first ${MOST} of ${columns.length} columns are shown: choose values of the axes; the CSV has all.`] };
  }
  function openCell(id) {
    choose({ cell: String(id) });
    pick("pairs").scrollIntoView({ block: "nearest" });
    pick("rows").querySelector(`[data-effect="${id}"]`)?.focus({ preventScroll: true });
  }

  function drawPairs(chosen) {
    const effect = chosen.cell === "" ? undefined : data.effects[chosen.cell];
    pick("pairs").hidden = !effect || data.models[effect.model] !== chosen.model || effect.quantity !== chosen.quantity || !(effect.demand in runs.demands);
    if (pick("pairs").hidden) return () => [];
    const factor = Number(chosen.margin), ratio = effect.judged_by === RATIO, values = runs.demands[effect.demand], known = data.demands[effect.demand];
    const by = ratio ? 1 : shownUnit(effect, chosen.units).by * known.per_unit, found = pairsOf(effect), rows = [], traces = [];
    const styles = lineStyles(found.slice(0, MOST).map(({ to }) => to));
    found.forEach(({ from, to, rows: pairs }) => {
      const usable = pairs.filter(([a, b]) => (runs.complete[a] || runs.complete[b]) && values[a] !== null && values[b] !== null && (!ratio || (values[a] > 0 && values[b] > 0)));
      const change = ([a, b]) => (ratio ? Math.log(values[b] / values[a]) : by * (values[b] - values[a]));
      const symbol = ([a, b]) => (runs.complete[a] && runs.complete[b] ? "circle" : runs.complete[a] ? "triangle-up-open" : "triangle-down-open");
      usable.forEach((pair) => rows.push({ from_variant: variants[from].name, to_variant: variants[to].name, motion_id: data.motions[runs.motion[pair[1]]], scale: runs.scale[pair[1]], demand: effect.demand, from_demand: values[pair[0]], to_demand: values[pair[1]], change: change(pair), of: ratio ? "ln ratio" : shownUnit(effect, chosen.units).unit, bound: { circle: "", "triangle-up-open": "at least", "triangle-down-open": "at most" }[symbol(pair)], from_run_key: runs.key[pair[0]], to_run_key: runs.key[pair[1]] }));
      traces.push({ x: usable.map((pair) => runs.im[pair[1]]), y: usable.map(change), mode: "markers", customdata: usable, text: usable.map((pair) => `${variants[to].text}<br>${loadingText(pair[1])}`), hovertemplate: "%{text}<br>%{x:.3g}, %{y:.3g}<extra></extra>", marker: { color: styles.get(to)?.color ?? COLOURS[4], symbol: usable.map(symbol), size: 7, opacity: 0.75 } });
    });
    const scaled = (value) => (value === null ? null : ratio ? Math.log(value) : shownUnit(effect, chosen.units).by * value);
    const [low, value, high] = [effect.low, effect.value, effect.high].map(scaled), margins = marginsOf(effect, factor).map((end) => (ratio ? end : shownUnit(effect, chosen.units).by * end));
    const band = (y0, y1, fillcolor) => ({ type: "rect", xref: "paper", x0: 0, x1: 1, y0, y1, fillcolor, line: { width: 0 }, layer: "below" });
    const shapes = [band(...margins, "#e9edf0"), { type: "line", xref: "paper", x0: 0, x1: 1, y0: 0, y1: 0, line: { color: "#6b7378", width: 1 } }];
    if (low !== null && high !== null) shapes.push(band(low, high, "#0072b233"));
    if (value !== null) shapes.push({ type: "line", xref: "paper", x0: 0, x1: 1, y0: value, y1: value, line: { color: "#0072b2", width: 2 } });
    const name = known.label.toLowerCase();
    pick("pairs-title").textContent = `${known.label}: ${effect.change}${effect.values ? ", " + placeText(effect) : ", all variants"}`;
    pick("pairs-note").textContent = `${changeText(effect, chosen.units)} (${intervalText(effect, chosen.units)}), ${effect.n_motions} motions, ${rows.length} pairs. Line and blue band: mean and interval; grey: margin. Open triangles: one analysis of the pair ended early or a column failed, so the change is a lower (up) or upper (down) bound.`;
    plot("pairs-plot", traces, { height: 360, shapes, xaxis: logAxis(data.im, ...data.im_range), yaxis: plainAxis(ratio ? `ln ratio of ${name}` : `Change of ${name} (${shownUnit(effect, chosen.units).unit})`) }, showCommands);
    return () => rows;
  }
