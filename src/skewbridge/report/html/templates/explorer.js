"use strict";
(() => {
  const data = JSON.parse(document.getElementById("explorer-data").textContent);
  const box = document.getElementById("explorer");
  const pick = (id) => document.getElementById("ex-" + id);
  const unique = (list) => [...new Set(list)];
  const US = { m: [39.37007874, "in"], kN: [0.2248089431, "kip"] };
  const colours = ["#0072b2", "#b84f00", "#007a5a", "#7b4b94", "#56616a", "#a8761d", "#3a9bd4", "#8c2d4f"];
  const dashes = ["solid", "dash", "dot", "dashdot", "longdash"];

  // the error function after Cody's rational forms in W. J. Cody (1969), Math. Comp. 23:631-637
  function erfc(x) {
    const a = Math.abs(x); let r;
    if (a < 0.5) {
      const y = a * a;
      const n = (((1.85777706184603153e-1 * y + 3.16112374387056560) * y + 1.13864154151050156e2) * y + 3.77485237685302021e2) * y + 3.20937758913846947e3;
      const d = (((y + 2.36012909523441209e1) * y + 2.44024637934444173e2) * y + 1.28261652607737228e3) * y + 2.84423683343917062e3;
      r = 1 - a * n / d;
    } else if (a < 4) {
      const p = [2.15311535474403846e-8, 5.64188496988670089e-1, 8.88314979438837594, 6.61191906371416295e1, 2.98635138197400131e2, 8.81952221241769090e2, 1.71204761263407058e3, 2.05107837782607147e3, 1.23033935479799725e3];
      const q = [1, 1.57449261107098347e1, 1.17693950891312499e2, 5.37181101862009858e2, 1.62138957456669019e3, 3.29079923573345963e3, 4.36261909014324716e3, 3.43936767414372164e3, 1.23033935480374942e3];
      const at = (c) => c.reduce((s, v) => s * a + v, 0);
      r = Math.exp(-a * a) * at(p) / at(q);
    } else {
      const y = 1 / (a * a);
      const n = ((((1.63153871373020978e-2 * y + 3.05326634961232344e-1) * y + 3.60344899949804439e-1) * y + 1.25781726111229246e-1) * y + 1.60837851487422766e-2) * y + 6.58749161529837803e-4;
      const d = ((((y + 2.56852019228982242) * y + 1.87295284992346047) * y + 5.27905102951428412e-1) * y + 6.05183413124413191e-2) * y + 2.33520497626869185e-3;
      r = Math.exp(-a * a) / a * (1 / Math.sqrt(Math.PI) - y * n / d);
    }
    return x < 0 ? 2 - r : r;
  }
  const phi = (z) => 0.5 * erfc(-z / Math.SQRT2);
  window.skewbridgeProbability = (im, theta, beta) => phi(Math.log(im / theta) / beta);
  function quantile(p) { let lo = -9, hi = 9; for (let i = 0; i < 80; i++) { const m = (lo + hi) / 2; if (phi(m) < p) lo = m; else hi = m; } return lo; }

  function options(id, values, texts) {
    const old = pick(id).value;
    pick(id).replaceChildren(...values.map((v, i) => new Option(texts ? texts[i] : v, v)));
    pick(id).value = values.map(String).includes(old) ? old : values[0];
  }
  const names = Object.keys(data.variants);
  const fixed = ["view", "model", "state", "method", "units"];
  const controls = [...fixed, ...data.axes.map((a) => a.name)];
  options("model", unique(names.map((n) => data.variants[n].model)));
  data.axes.forEach((axis) => {
    const values = unique(names.map((n) => data.variants[n][axis.name])).sort((a, b) => a - b);
    const label = document.createElement("label");
    label.textContent = axis.label + " ";
    const select = document.createElement("select");
    select.id = "ex-" + axis.name;
    label.append(select);
    pick("axes").append(label);
    options(axis.name, ["all", ...values]);
  });
  const words = (s) => s.replaceAll("_", " ");
  options("state", unique(data.fits.map((f) => f.component + "/" + f.limit_state)), unique(data.fits.map((f) => words(f.component + ", " + f.limit_state))));
  options("method", unique(data.fits.map((f) => f.method)));

  function fromHash() {
    const told = new URLSearchParams(location.hash.replace(/^#explorer\??/, ""));
    if (location.hash.startsWith("#explorer")) controls.forEach((c) => { if (told.has(c)) pick(c).value = told.get(c); if (!pick(c).value) pick(c).selectedIndex = 0; });
  }
  const kept = (n) => data.variants[n].model === pick("model").value && data.axes.every((a) => pick(a.name).value === "all" || String(data.variants[n][a.name]) === pick(a.name).value);
  let rows = [];
  function factor(demand) {
    const label = data.demands[demand] || demand;
    const unit = (label.match(/\((m|kN)\)$/) || [])[1];
    return pick("units").value === "us" && unit ? { by: US[unit][0], label: label.replace(/\((m|kN)\)$/, "(" + US[unit][1] + ")") } : { by: 1, label };
  }
  const layout = (x, y, extra) => ({ margin: { l: 60, r: 10, t: 10, b: 50 }, height: 460, hovermode: "closest", legend: { orientation: "h", y: -0.18 }, xaxis: { title: { text: x }, type: "log" }, yaxis: { title: { text: y }, ...extra } });
  const style = (i) => ({ color: colours[i % colours.length], dash: dashes[Math.floor(i / colours.length) % dashes.length] });

  function drawCurves(fits) {
    const ims = data.runs.im, low = 0.7 * Math.min(...ims), high = 1.3 * Math.max(...ims);
    const grid = Array.from({ length: 120 }, (_, i) => low * (high / low) ** (i / 119));
    const traces = [];
    const demand = fits.length ? fits[0].demand : "", usable = fits.length && fits.every((f) => f.sigma > 0 && f.b > 0);
    const unit = factor(demand), slider = pick("threshold");
    slider.disabled = !usable; pick("threshold-box").hidden = !usable;
    let limit = fits.length ? fits[0].threshold : 1;
    if (usable) {
      const seen = data.runs[demand].filter((v, i) => v > 0 && kept(data.runs.variant[i]));
      const a = Math.log(Math.min(...seen)), b = Math.log(Math.max(...seen));
      if (slider.dataset.of !== demand + limit) { slider.dataset.of = demand + limit; slider.value = "0"; slider.dataset.moved = ""; }
      if (slider.dataset.moved) limit = Math.exp(a + (b - a) * slider.value / 1000);
      else slider.value = String(Math.round(1000 * Math.min(1, Math.max(0, (Math.log(limit) - a) / (b - a)))));
      pick("threshold-text").textContent = (limit * unit.by).toPrecision(3) + " " + unit.label + (slider.dataset.moved ? ", no dispersion of the capacity, no band" : ", the limit state");
    }
    rows = [];
    fits.forEach((f, i) => {
      const moved = usable && slider.dataset.moved, z = quantile(0.5 + f.level / 2);
      const theta = moved ? Math.exp((Math.log(limit) - f.ln_a) / f.b) : f.theta, beta = moved ? f.sigma / f.b : f.beta_total;
      const slope = f.beta / f.beta_total, text = data.variants[f.variant].text;
      const p = grid.map((im) => phi(Math.log(im / theta) / beta));
      if (!moved) {
        const se = grid.map((im) => { const u = Math.log(im / theta) / beta; return Math.sqrt(Math.max(0, f.var_ln_theta + 2 * u * f.cov_ln_theta_beta * slope + u * u * f.var_beta * slope * slope)) / beta; });
        const band = (s) => grid.map((im, k) => phi(Math.log(im / theta) / beta + s * z * se[k]));
        traces.push({ x: grid, y: band(-1), mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false, legendgroup: text });
        traces.push({ x: grid, y: band(1), mode: "lines", line: { width: 0 }, fill: "tonexty", fillcolor: style(i).color + "1c", hoverinfo: "skip", showlegend: false, legendgroup: text });
      }
      traces.push({ x: grid, y: p, mode: "lines", name: text, legendgroup: text, line: { ...style(i), width: 2 }, hovertemplate: text + "<br>IM %{x:.3g}<br>P %{y:.3f}<extra></extra>" });
      grid.forEach((im, k) => rows.push({ variant: f.variant, component: f.component, limit_state: f.limit_state, method: f.method, im, probability: p[k] }));
    });
    Plotly.react("ex-plot", traces, layout(data.im, "P(exceeds | IM)", { range: [0, 1] }), { responsive: true, displaylogo: false });
  }

  function drawCloud(fits) {
    const demand = fits.length ? fits[0].demand : Object.keys(data.demands)[0], unit = factor(demand), traces = [];
    rows = [];
    names.filter(kept).forEach((n, i) => {
      const at = data.runs.variant.flatMap((v, k) => (v === n && data.runs[demand][k] > 0 ? [k] : []));
      const done = (k) => data.runs.status[k] === "ok";
      traces.push({ x: at.map((k) => data.runs.im[k]), y: at.map((k) => unit.by * data.runs[demand][k]), mode: "markers", name: data.variants[n].text,
        marker: { color: style(i).color, symbol: at.map((k) => (done(k) ? "circle" : "triangle-up-open")), size: 7, opacity: 0.75 },
        customdata: at.map((k) => [data.runs.motion[k], data.runs.status[k], data.runs.key[k]]),
        hovertemplate: data.variants[n].text + "<br>%{customdata[0]}, %{customdata[1]}<br>%{x:.3g}, %{y:.4g}<extra></extra>" });
      at.forEach((k) => rows.push({ variant: n, motion_id: data.runs.motion[k], status: data.runs.status[k], run_key: data.runs.key[k], im: data.runs.im[k], [demand]: data.runs[demand][k] }));
    });
    Plotly.react("ex-plot", traces, layout(data.im, unit.label, { type: "log" }), { responsive: true, displaylogo: false });
    pick("plot").removeAllListeners?.("plotly_click");
    pick("plot").on("plotly_click", (event) => { pick("command").textContent = "skewbridge run --row " + event.points[0].customdata[2]; });
  }

  const heads = ["variant", "component", "limit_state", "method", "theta", "theta_low", "theta_high", "beta", "beta_total", "n_exceed", "n_runs"];
  let order = { by: "variant", down: false };
  function drawTable() {
    rows = data.fits.filter((f) => kept(f.variant) && f.method === pick("method").value).map((f) => Object.fromEntries(heads.map((h) => [h, f[h]])));
    rows.sort((a, b) => (a[order.by] > b[order.by] ? 1 : a[order.by] < b[order.by] ? -1 : 0) * (order.down ? -1 : 1));
    const table = document.createElement("table"), head = table.createTHead().insertRow(), body = table.createTBody();
    heads.forEach((h) => {
      const cell = document.createElement("th"), button = document.createElement("button");
      button.textContent = words(h) + (order.by === h ? (order.down ? " ▼" : " ▲") : "");
      button.onclick = () => { order = { by: h, down: order.by === h && !order.down }; draw(); };
      cell.scope = "col"; cell.append(button); head.append(cell);
    });
    rows.forEach((r) => { const line = body.insertRow(); heads.forEach((h) => { const v = r[h]; line.insertCell().textContent = v === null ? "–" : typeof v === "number" ? String(+v.toPrecision(4)) : words(v); }); });
    pick("rows").replaceChildren(table);
  }

  function draw() {
    const [component, state] = pick("state").value.split("/"), view = pick("view").value;
    pick("plot").hidden = view === "table"; pick("rows").hidden = view !== "table"; pick("threshold-box").hidden = view !== "curves";
    pick("command").textContent = view === "cloud" ? "Choose a point: its command stands here." : "";
    const fits = data.fits.filter((f) => f.component === component && f.limit_state === state && f.method === pick("method").value && kept(f.variant));
    if (view === "curves") drawCurves(fits); else if (view === "cloud") drawCloud(fits.length ? fits : data.fits.filter((f) => f.component === component)); else drawTable();
    pick("note").textContent = view === "curves" && !fits.length ? "No curve of this state and method for these variants." : view === "cloud" ? data.sample_note : "";
  }
  function changed() {
    const told = new URLSearchParams(controls.map((c) => [c, pick(c).value]));
    history.replaceState(null, "", "#explorer?" + told);
    draw();
  }
  controls.forEach((c) => pick(c).addEventListener("change", changed));
  pick("threshold").addEventListener("input", () => { pick("threshold").dataset.moved = "yes"; draw(); });
  pick("csv").addEventListener("click", () => {
    const columns = Object.keys(rows[0] || {}), link = document.createElement("a");
    const text = [columns.join(","), ...rows.map((r) => columns.map((c) => r[c] ?? "").join(","))].join("\n");
    link.href = URL.createObjectURL(new Blob([text + "\n"], { type: "text/csv" }));
    link.download = "skewbridge_" + pick("view").value + ".csv"; link.click(); URL.revokeObjectURL(link.href);
  });
  window.addEventListener("hashchange", () => { if (location.hash.startsWith("#explorer")) { fromHash(); draw(); } });
  box.hidden = false;
  fromHash();
  draw();
})();
