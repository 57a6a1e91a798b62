  // ---- drawing: line styles, legend, plot, tables ----
  const COLOURS = data.colours;
  const DASHES = ["solid", "dash", "dot", "dashdot", "longdash"];
  const DASH_ARRAYS = { solid: "", dash: "9 5", dot: "2 3", dashdot: "9 4 2 4", longdash: "14 5" };
  const WIDTHS = [2.2, 1.1, 3.6];
  const pick = (id) => document.getElementById("ex-" + id);
  const element = (tag, text, attributes = {}) => {
    const made = document.createElement(tag);
    made.textContent = text;
    Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
    return made;
  };

  // colour, dashes and width show up to three varying axes; if they do not suffice, each variant has its own colour and dashes
  function lineStyles(shown) {
    const varying = data.axes.map((_, place) => unique(shown.map((at) => variants[at].values[place])).sort((a, b) => a - b)).map((values, place) => ({ values, place })).filter(({ values }) => values.length > 1).sort((a, b) => b.values.length - a.values.length);
    const rooms = [COLOURS, DASHES, WIDTHS];
    const suffices = varying.length <= rooms.length && varying.every(({ values }, rank) => values.length <= rooms[rank].length);
    return new Map(shown.map((at, i) => {
      const step = (rank) => (varying[rank] ? varying[rank].values.indexOf(variants[at].values[varying[rank].place]) : 0);
      const [colour, dash, width] = suffices ? [step(0), step(1), step(2)] : [i % COLOURS.length, Math.floor(i / COLOURS.length) % DASHES.length, 0];
      return [at, { color: COLOURS[colour], dash: DASHES[dash], width: WIDTHS[width] }];
    }));
  }

  const offNames = () => new Set(chosen.off.split(";").filter(Boolean)); // entries of the legend that are switched off
  function legend(entries) {
    const hidden = offNames();
    const picture = ({ line, marker }) => (line
      ? `<svg width="34" height="10" aria-hidden="true"><line x1="1" x2="33" y1="5" y2="5" stroke="${line.color}" stroke-width="${line.width}" stroke-dasharray="${DASH_ARRAYS[line.dash]}"/></svg>`
      : `<svg width="12" height="10" aria-hidden="true"><circle cx="6" cy="5" r="4" fill="${marker}"/></svg>`);
    pick("legend").replaceChildren(...entries.map((entry) => {
      const button = element("button", entry.name, { type: "button", "aria-pressed": String(!hidden.has(entry.name)) });
      button.insertAdjacentHTML("afterbegin", picture(entry));
      button.addEventListener("click", () => { if (!hidden.delete(entry.name)) hidden.add(entry.name); choose({ off: [...hidden].join(";") }); });
      return button;
    }));
  }

  // ticks of an axis of ratios, labelled with changes in per cent
  const PERCENT_TICKS = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.25, 1.5, 2, 2.5];
  // ticks at 1, 2 and 5 of each decade, or at the decades only if there are many
  function logAxis(title, low, high) {
    const from = Math.floor(Math.log10(low)) - 1, decades = Array.from({ length: Math.ceil(Math.log10(high)) - from + 2 }, (_, i) => 10 ** (from + i));
    const ticks = Math.log10(high / low) > 3 ? decades : decades.flatMap((decade) => [decade, 2 * decade, 5 * decade]);
    return { title: { text: title }, type: "log", tickmode: "array", tickvals: ticks, ticktext: ticks.map((tick) => String(+tick.toPrecision(1))), gridcolor: "#e4e8ea", linecolor: "#6b7378", ticks: "outside", automargin: true };
  }
  const plainAxis = (title, more) => ({ title: { text: title }, gridcolor: "#e4e8ea", linecolor: "#6b7378", ticks: "outside", zeroline: false, automargin: true, ...more });
  function percentTicks([low, high], most) {
    const kept = [1], apart = Math.log(high / low) / most;
    PERCENT_TICKS.filter((tick) => tick >= low && tick <= high).sort((a, b) => Math.abs(Math.log(b)) - Math.abs(Math.log(a))).forEach((tick) => { if (kept.every((other) => Math.abs(Math.log(tick / other)) > apart)) kept.push(tick); });
    return { tickmode: "array", tickvals: kept, ticktext: kept.map((tick) => (tick === 1 ? "0" : (tick > 1 ? "+" : "-") + Math.round(100 * Math.abs(tick - 1)) + " %")) };
  }
  function plot(id, traces, layout, onPick) {
    const box = pick(id), first = !box.on;
    box.hidden = false;
    Plotly.react(box, traces, { margin: { l: 64, r: 12, t: 12, b: 52 }, height: 440, hovermode: "closest", showlegend: false, font: { size: 13, color: "#1c2226" }, ...layout }, { responsive: true, displaylogo: false, displayModeBar: false });
    box.picked = onPick;
    if (first) box.on("plotly_click", (event) => box.picked?.(event.points[0].customdata));
  }
  // commands that repeat the analyses of a point, each with a button that copies it
  function showCommands(rows) {
    pick("commands").replaceChildren(...rows.map((row) => {
      const line = element("p", ""), text = command(row), button = element("button", "copy", { type: "button", "aria-label": "copy " + text });
      button.addEventListener("click", () => navigator.clipboard.writeText(text).then(() => { button.textContent = "copied"; }));
      line.append(...(text ? [element("code", text), " ", button] : []), ` ${variants[runs.variant[row]].text}; ${loadingText(row)}`);
      return line;
    }));
  }

  function csvText(rows) {
    const columns = Object.keys(rows[0] ?? {});
    const cell = (value) => (/[",\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : value);
    return [columns.join(","), ...rows.map((row) => columns.map((name) => cell(row[name] ?? "")).join(","))].join("\n") + "\n";
  }
