  // ---- choices, their controls and the address ----
  const VIEWS = { curves: drawCurves, cloud: drawAnalyses, table: drawMedians, forest: drawForest, grid: drawGrid };
  const states = unique(data.fits.map((fit) => fit.component + "/" + fit.limit_state));
  const changes = new Map(data.models.map((model, place) => [model, unique(data.effects.filter((effect) => effect.model === place && !effect.values).map((effect) => effect.change))]));
  const defaults = { view: "curves", model: data.models[0], state: states[0] ?? "", method: "preferred", quantity: "median_capacity", demand: Object.keys(data.demands)[0], change: "", scope: "pooled", units: data.units, margin: "1", threshold: "", sort: "variant", cell: "", off: "", ...Object.fromEntries(data.axes.map((axis) => [axis.name, "all"])) };
  let chosen = { ...defaults };
  const noEffect = {}; // reasons why a shown control has no effect
  let shownRows; // function that returns the rows of the shown table, called when they are saved

  function fill(id, values, texts = values) {
    pick(id).replaceChildren(...values.map((value, i) => new Option(texts[i], value)));
  }
  data.axes.forEach((axis) => {
    const label = element("label", axis.label + " ", { "data-views": "curves cloud table forest grid" }), select = element("select", "", { id: "ex-" + axis.name });
    label.append(select);
    pick("units").parentElement.before(label);
    fill(axis.name, ["all", ...axis.values], ["all", ...axis.texts]);
  });
  fill("model", data.models);
  fill("state", states, states.map((state) => words(state.replace("/", ", "))));
  fill("demand", Object.keys(data.demands), Object.values(data.demands).map((demand) => demand.label));
  const methods = ["preferred", ...unique(data.fits.map((fit) => fit.method))];
  fill("method", methods, methods.map(words));
  fill("margin", data.factors, data.factors.map((factor) => "× " + factor));
  const SELECTS = ["view", "model", "state", "method", "quantity", "demand", "change", "scope", "units", "margin", ...data.axes.map((axis) => axis.name)];

  function redraw() {
    if (!(chosen.view in VIEWS)) chosen.view = defaults.view;
    const view = chosen.view, effects = view === "forest" || view === "grid";
    if (!changes.has(chosen.model)) chosen.model = defaults.model;
    const own = changes.get(chosen.model);
    fill("change", own);
    if (!own.includes(chosen.change)) chosen.change = own.at(-1) ?? "";
    SELECTS.forEach((name) => { pick(name).value = chosen[name]; if (pick(name).selectedIndex < 0) { pick(name).selectedIndex = 0; chosen[name] = pick(name).value; } });
    const single = chosen.scope === "variant", ofDemands = chosen.quantity === "demand";
    pick("demand").parentElement.dataset.views = single && ofDemands ? "cloud forest" : "cloud";
    pick("state").parentElement.dataset.views = single && !ofDemands ? "curves forest" : "curves";
    document.querySelectorAll("#explorer [data-views]").forEach((label) => { label.hidden = !label.dataset.views.split(" ").includes(view); });
    const axisOfChange = data.effects.find((effect) => effect.change === chosen.change)?.axis;
    const only = (name, what) => (pick(name).length < 2 ? `${what}: there is only one` : "");
    data.axes.forEach((axis) => {
      noEffect[axis.name] = axis.values.length < 2 ? `${axis.label}: the study has one value` : !effects ? "" : chosen.scope === "pooled" ? `${axis.label}: averaged over; choose “each pair of variants”` : view === "forest" && axis.name === axisOfChange ? `${axis.label}: this axis changes` : "";
    });
    noEffect.model = only("model", "bridge, abutment");
    noEffect.state = only("state", "component, state");
    noEffect.demand = only("demand", "demand");
    noEffect.change = only("change", "change");
    noEffect.threshold = "";
    ["plot", "rows", "pairs", "threshold-box"].forEach((id) => { pick(id).hidden = true; });
    pick("commands").replaceChildren();
    legend([]);
    pick("margin-text").textContent = effects ? marginText(chosenEffects(chosen), Number(chosen.margin), chosen.units) + (chosen.margin === "1" ? " (the study's)" : ` (the study's times ${chosen.margin})`) : "";
    const drawn = VIEWS[view](chosen);
    const hasUnits = view === "curves" ? !pick("threshold-box").hidden : view === "cloud" ? data.demands[chosen.demand].unit in data.us : chosenEffects(chosen).some((effect) => effect.unit in data.us);
    noEffect.units = hasUnits ? "" : "units: no length or force is shown";
    SELECTS.forEach((name) => { pick(name).disabled = Boolean(noEffect[name]); pick(name).title = noEffect[name] ?? ""; });
    const isShown = (name) => name === "threshold" ? view === "curves" : !pick(name).parentElement.hidden;
    const reasons = Object.keys(noEffect).filter((name) => noEffect[name] && isShown(name)).map((name) => noEffect[name]);
    pick("why").textContent = reasons.length ? `Without effect here: ${reasons.join("; ")}.` : "";
    shownRows = { view: drawn.rows, pairs: effects ? drawPairs(chosen) : () => [] };
    pick("note").textContent = drawn.notes.filter(Boolean).join(" ");
  }
  function choose(change) {
    chosen = { ...chosen, ...change };
    redraw();
    const changed = Object.entries(chosen).filter(([name, value]) => value !== defaults[name] && !(name === "change" && chosen.view !== "forest"));
    history.replaceState(null, "", "#explorer" + (changed.length ? "?" + new URLSearchParams(changed) : ""));
  }
  function fromAddress() {
    const given = new URLSearchParams(location.hash.replace(/^#explorer\??/, ""));
    chosen = { ...defaults, ...Object.fromEntries([...given].filter(([name]) => name in defaults)) };
    if (!data.factors.includes(Number(chosen.margin))) chosen.margin = "1";
    if (!(chosen.cell in data.effects)) chosen.cell = "";
    redraw();
  }
  function save(name, rows) {
    const link = element("a", "", { download: `skewbridge_${name}.csv`, href: URL.createObjectURL(new Blob([csvText(rows)], { type: "text/csv" })) });
    link.click();
    URL.revokeObjectURL(link.href);
  }

  SELECTS.forEach((name) => pick(name).addEventListener("change", () => choose({ [name]: pick(name).value, ...(["state", "method", "model"].includes(name) ? { threshold: "" } : {}), ...(name === "model" ? { cell: "" } : {}) })));
  let waiting = false; // a moving slider redraws once per screen refresh
  const sliding = (name) => pick(name).addEventListener("input", () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; choose({ [name]: pick(name).value }); });
  });
  sliding("threshold");
  pick("threshold-reset").addEventListener("click", () => choose({ threshold: "" }));
  pick("csv").addEventListener("click", () => save(chosen.view, shownRows.view()));
  pick("pairs-csv").addEventListener("click", () => save("pairs", shownRows.pairs()));
  window.addEventListener("hashchange", () => { if (location.hash.startsWith("#explorer")) fromAddress(); });
  pick("missing").remove();
  document.getElementById("explorer").hidden = false;
  if (location.hash.startsWith("#explorer")) { fromAddress(); document.getElementById("explore").scrollIntoView(); } else redraw();
