// Explorer: fragility curves and analyses of chosen variants, with their values as CSV.
"use strict";
(async () => {
  // data and plotting library are compressed, so that the page stays small
  async function unpacked(id) {
    const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }
  const library = document.createElement("script");
  library.textContent = await unpacked("explorer-library");
  document.head.append(library);
  const data = JSON.parse(await unpacked("explorer-data")), { variants, runs } = data;
  const MOST = 24; // largest number of curves or variants in a figure
  const BANDS = 2; // largest number of curves with bands: more would hide each other
  const unique = (list) => [...new Set(list)];
  const words = (text) => String(text).replaceAll("_", " ").replace(/\bdcr (\d)(\d\d)\b/, "DCR $1.$2");
  const pick = (id) => document.getElementById("ex-" + id);
  const element = (tag, text, attributes = {}) => {
    const made = document.createElement(tag);
    made.textContent = text;
    Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
    return made;
  };
  const rowsOf = variants.map(() => []);
  runs.variant.forEach((variant, row) => rowsOf[variant].push(row));
  const matches = (values) => data.axes.every((axis, place) => chosen[axis.name] === "all" || String(values[place]) === chosen[axis.name]);
  const chosenVariants = () => variants.map((_, place) => place).filter((place) => data.models[variants[place].model] === chosen.model && matches(variants[place].values));
  const loadingText = (row) => data.motions[runs.motion[row]] + (runs.status[row] ? ", " + words(data.statuses[runs.status[row]]) : "") + (runs.complete[row] ? "" : ", a lower bound");

  // ---- drawing ----
  const DASHES = { solid: "", dash: "9 5", dot: "2 3", dashdot: "9 4 2 4", longdash: "14 5" };
  // a colour for each value of the axis with most values, dashes for the next axes
  function lineStyles(shown) {
    const varying = data.axes.map((_, place) => ({ place, values: unique(shown.map((at) => variants[at].values[place])).sort((a, b) => a - b) })).sort((a, b) => b.values.length - a.values.length);
    const names = Object.keys(DASHES);
    return new Map(shown.map((at) => {
      const [colour, ...others] = varying.map(({ place, values }) => values.indexOf(variants[at].values[place]));
      const dash = others.reduce((number, step, i) => number * varying[i + 1].values.length + step, 0);
      return [at, { color: data.colours[colour % data.colours.length], dash: names[dash % names.length], width: 1.8 }];
    }));
  }
  const offNames = () => new Set(chosen.off.split(";").filter(Boolean)); // entries of the legend that are switched off
  function legend(entries) {
    const hidden = offNames();
    pick("legend").replaceChildren(...entries.map(({ name, line }) => {
      const button = element("button", name, { type: "button", "aria-pressed": String(!hidden.has(name)) });
      button.insertAdjacentHTML("afterbegin", `<svg width="34" height="10" aria-hidden="true"><line x1="1" x2="33" y1="5" y2="5" stroke="${line.color}" stroke-width="${line.width}" stroke-dasharray="${DASHES[line.dash]}"/></svg>`);
      button.addEventListener("click", () => { if (!hidden.delete(name)) hidden.add(name); choose({ off: [...hidden].join(";") }); });
      return button;
    }));
  }
  const look = (title, more) => ({ title: { text: title }, gridcolor: "#e4e8ea", linecolor: "#6b7378", ticks: "outside", zeroline: false, automargin: true, ...more });
  // ticks at 1, 2 and 5 of each decade, or at the decades only if there are many
  function logAxis(title, low, high) {
    const from = Math.floor(Math.log10(low)) - 1, decades = Array.from({ length: Math.ceil(Math.log10(high)) - from + 2 }, (_, i) => 10 ** (from + i));
    const ticks = Math.log10(high / low) > 3 ? decades : decades.flatMap((decade) => [decade, 2 * decade, 5 * decade]);
    return look(title, { type: "log", tickmode: "array", tickvals: ticks, ticktext: ticks.map((tick) => String(+tick.toPrecision(1))) });
  }
  function plot(traces, layout) {
    const box = pick("plot"), first = !box.on;
    Plotly.react(box, traces, { margin: { l: 64, r: 12, t: 12, b: 52 }, height: 440, hovermode: "closest", showlegend: false, font: { size: 13, color: "#1c2226" }, ...layout }, { responsive: true, displaylogo: false, displayModeBar: false });
    if (first) box.on("plotly_click", (event) => { if (event.points[0].customdata !== undefined) showCommand(event.points[0].customdata); });
  }
  function showCommand(row) {
    const line = element("p", ""), command = runs.key[row] && "skewbridge run --row " + runs.key[row];
    line.append(...(command ? [element("code", command)] : []), ` ${variants[runs.variant[row]].text}; ${loadingText(row)}`);
    pick("commands").replaceChildren(line);
  }

  // ---- fragility curves: probabilities and bands at the intensities data.im_values ----
  function drawCurves() {
    const there = new Set(chosenVariants()), [component, state] = chosen.state.split("/"), off = offNames(), traces = [], im = data.im_values;
    const all = data.fits.filter((fit) => fit.component === component && fit.limit_state === state && (chosen.method === "preferred" ? fit.preferred : fit.method === chosen.method) && there.has(fit.variant));
    const fits = all.slice(0, MOST), styles = lineStyles(fits.map((fit) => fit.variant));
    const rows = () => all.flatMap((fit) => im.map((value, i) => ({ variant: variants[fit.variant].name, component, limit_state: state, method: fit.method, theta: fit.theta, beta: fit.beta_total, im: value, probability: fit.curve[0][i], low: fit.curve[1][i], high: fit.curve[2][i], extrapolated: value < fit.im_low || value > fit.im_high })));
    legend(fits.map((fit) => ({ name: variants[fit.variant].text, line: styles.get(fit.variant) })));
    fits.filter((fit) => !off.has(variants[fit.variant].text)).forEach((fit) => {
      const name = variants[fit.variant].text, line = styles.get(fit.variant);
      if (fits.length <= BANDS) [1, 2].forEach((side) => traces.push({ x: im, y: fit.curve[side], mode: "lines", line: { width: 0 }, hoverinfo: "skip", ...(side > 1 ? { fill: "tonexty", fillcolor: line.color + "26" } : {}) }));
      traces.push({ x: im, y: fit.curve[0], mode: "lines", name, line, hovertemplate: `${name}, median ${+fit.theta.toPrecision(3)}<br>%{x:.3g}, P = %{y:.3f}<extra></extra>` });
    });
    plot(traces, { xaxis: logAxis(data.im, im[0], im.at(-1)), yaxis: look("P(exceeds | IM)", { range: [0, 1.01] }) });
    const outside = all.filter((fit) => fit.extrapolated), differing = all.filter((fit) => fit.methods_differ);
    return { rows, notes: [
      !all.length && "No curve of this state for these variants and this method: see the list of states that no analysis reached, in the tables.",
      outside.length > 0 && `The medians of ${outside.length} of ${all.length} curves are extrapolated: fewer than three motions are as strong, or as weak.`,
      differing.length > 0 && `The exceedance median differs from the cloud median in ${differing.length} of ${all.length} curves.`,
      all.length > MOST && `The first ${MOST} of ${all.length} curves are drawn: choose values of the axes; the CSV has all.`,
      all.length > BANDS && `Bands are drawn for at most ${BANDS} curves: choose values of the axes.`] };
  }

  // ---- the analyses: demand against intensity ----
  function drawAnalyses() {
    const all = chosenVariants(), shown = all.slice(0, MOST), styles = lineStyles(shown), traces = [], off = offNames();
    const demand = chosen.demand, { factor, label } = data.demands[demand], values = runs.demands[demand];
    const rows = () => all.flatMap((at) => rowsOf[at].map((row) => ({ variant: variants[at].name, motion_id: data.motions[runs.motion[row]], scale: runs.scale[row], status: data.statuses[runs.status[row]], complete: runs.complete[row], run_key: runs.key[row], [data.im_name]: runs.im[row], [demand]: values[row] })));
    legend(shown.map((at) => ({ name: variants[at].text, line: styles.get(at) })));
    shown.filter((at) => !off.has(variants[at].text)).forEach((at) => {
      const name = variants[at].text, { color, dash } = styles.get(at), own = rowsOf[at].filter((row) => values[row] > 0);
      traces.push({ x: own.map((row) => runs.im[row]), y: own.map((row) => factor * values[row]), mode: "markers", customdata: own,
        text: own.map((row) => `${name}<br>${loadingText(row)}`), hovertemplate: "%{text}<br>%{x:.3g}, %{y:.4g}<extra></extra>",
        marker: { color, symbol: own.map((row) => (runs.complete[row] ? "circle" : "triangle-up-open")), size: 7, opacity: 0.75 } });
      const fit = data.fits.find((each) => each.variant === at && each.demand === demand && each.b !== null), ims = own.map((row) => runs.im[row]);
      if (!fit || !ims.length) return;
      const ends = [Math.min(...ims), Math.max(...ims)];
      if (fit.knot > ends[0] && fit.knot < ends[1]) ends.splice(1, 0, fit.knot);
      traces.push({ x: ends, y: ends.map((im) => factor * Math.exp(fit.ln_a) * im ** fit.b * (fit.knot === null ? 1 : Math.max(im / fit.knot, 1) ** (fit.b_above - fit.b))), mode: "lines", line: { color, dash, width: 1.4 }, hoverinfo: "skip" });
    });
    const marks = traces.flatMap((trace) => trace.y), seen = marks.length ? [Math.min(...marks), Math.max(...marks)] : [1, 10];
    const limits = unique(data.fits.filter((fit) => fit.demand === demand).map((fit) => fit.limit_state + "/" + fit.threshold)).map((text) => text.split("/"));
    const shapes = limits.map(([, limit]) => ({ type: "line", xref: "paper", x0: 0, x1: 1, y0: factor * limit, y1: factor * limit, line: { color: "#6b7378", width: 1, dash: "dot" } }));
    const annotations = limits.map(([state, limit]) => ({ xref: "paper", x: 0.01, xanchor: "left", y: Math.log10(factor * limit), yanchor: "bottom", text: words(state), showarrow: false, font: { size: 11, color: "#4a545c" } }));
    plot(traces, { xaxis: logAxis(data.im, data.im_values[0], data.im_values.at(-1)), yaxis: logAxis(label, ...seen), shapes, annotations });
    const own = all.flatMap((at) => rowsOf[at]), none = own.filter((row) => !(values[row] > 0)).length;
    return { rows, notes: [
      "Choose a point: the command that repeats its analysis appears below the picture.",
      own.some((row) => !runs.complete[row]) && "Open triangles: a column failed or the analysis ended early, so the demand is a lower bound.",
      none > 0 && `${none} analyses have a demand of zero and no mark.`,
      all.length > MOST && `The first ${MOST} of ${all.length} variants are drawn: choose values of the axes; the CSV has all.`] };
  }

  // ---- choices, their controls and the address ----
  const VIEWS = { curves: drawCurves, cloud: drawAnalyses };
  const states = unique(data.fits.map((fit) => fit.component + "/" + fit.limit_state)), methods = ["preferred", ...unique(data.fits.map((fit) => fit.method))];
  const defaults = { view: "curves", model: data.models[0], state: states[0], method: "preferred", demand: Object.keys(data.demands)[0], off: "", ...Object.fromEntries(data.axes.map((axis) => [axis.name, "all"])) };
  const SELECTS = Object.keys(defaults).filter((name) => name !== "off");
  let chosen = { ...defaults }, shownRows; // function that returns the rows of the shown figure
  const fill = (id, values, texts = values) => pick(id).replaceChildren(...values.map((value, i) => new Option(texts[i], value)));
  data.axes.forEach((axis) => {
    const label = element("label", axis.label + " ");
    label.append(element("select", "", { id: "ex-" + axis.name }));
    pick("csv").before(label);
    fill(axis.name, ["all", ...axis.values], ["all", ...axis.texts]);
  });
  fill("model", data.models);
  fill("state", states, states.map((state) => words(state.replace("/", ", "))));
  fill("demand", Object.keys(data.demands), Object.values(data.demands).map((demand) => demand.label));
  fill("method", methods, methods.map(words));
  function redraw() {
    SELECTS.forEach((name) => {
      pick(name).value = chosen[name];
      if (pick(name).selectedIndex < 0) { chosen[name] = defaults[name]; pick(name).value = chosen[name]; }
      // a control with one value has no effect
      pick(name).disabled = pick(name).length < 2 || data.axes.some((axis) => axis.name === name && axis.values.length < 2);
      pick(name).title = pick(name).disabled ? "There is only one value" : "";
    });
    document.querySelectorAll("#explorer [data-views]").forEach((label) => { label.hidden = label.dataset.views !== chosen.view; });
    pick("commands").replaceChildren();
    const drawn = VIEWS[chosen.view]();
    shownRows = drawn.rows;
    pick("note").textContent = drawn.notes.filter(Boolean).join(" ");
  }
  function choose(change) {
    chosen = { ...chosen, ...change };
    redraw();
    const changed = Object.entries(chosen).filter(([name, value]) => value !== defaults[name]);
    history.replaceState(null, "", "#explorer" + (changed.length ? "?" + new URLSearchParams(changed) : ""));
  }
  function fromAddress() {
    const given = new URLSearchParams(location.hash.replace(/^#explorer\??/, ""));
    chosen = { ...defaults, ...Object.fromEntries([...given].filter(([name]) => name in defaults)) };
    redraw();
  }
  function save() {
    const rows = shownRows(), columns = Object.keys(rows[0] ?? {});
    const cell = (value) => (/[",\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : value);
    const text = [columns.join(","), ...rows.map((row) => columns.map((name) => cell(row[name] ?? "")).join(","))].join("\n") + "\n";
    const link = element("a", "", { download: `skewbridge_${chosen.view}.csv`, href: URL.createObjectURL(new Blob([text], { type: "text/csv" })) });
    link.click();
    URL.revokeObjectURL(link.href);
  }
  SELECTS.forEach((name) => pick(name).addEventListener("change", () => choose({ [name]: pick(name).value })));
  pick("csv").addEventListener("click", save);
  window.addEventListener("hashchange", () => { if (location.hash.startsWith("#explorer")) fromAddress(); });
  pick("missing").remove();
  document.getElementById("explorer").hidden = false;
  if (location.hash.startsWith("#explorer")) { fromAddress(); document.getElementById("explore").scrollIntoView(); } else redraw();
})();
