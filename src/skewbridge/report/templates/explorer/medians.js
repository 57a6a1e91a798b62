  // ---- the sortable table of medians and dispersions ----
  const ROWS = 200; // drawn at once; the CSV has all
  const HEADS = { variant: "variant", component: "component", limit_state: "state", method: "method", theta: "θ", theta_low: "θ low", theta_high: "θ high", beta: "β", beta_total: "β total", n_exceed: "exceed", n_runs: "of" };
  function drawMedians(chosen) {
    const there = new Set(chosenVariants(chosen)), [by, down] = chosen.sort.split(" ");
    const rows = data.fits.filter((fit) => there.has(fit.variant) && ofMethod(fit, chosen)).map((fit) => ({ ...Object.fromEntries(Object.keys(HEADS).map((name) => [name, fit[name]])), variant: variants[fit.variant].name, extrapolated: fit.extrapolated }));
    const less = (a, b) => (a[by] === null ? 1 : b[by] === null ? -1 : a[by] < b[by] ? -1 : a[by] > b[by] ? 1 : 0);
    rows.sort((a, b) => (down ? -less(a, b) : less(a, b)));
    const table = element("table", ""), head = table.createTHead().insertRow(), body = table.createTBody();
    Object.entries(HEADS).forEach(([name, title]) => {
      const cell = element("th", "", { scope: "col", "aria-sort": by !== name ? "none" : down ? "descending" : "ascending" });
      const button = element("button", title + (by !== name ? "" : down ? " ▼" : " ▲"), { type: "button", "data-sort": name });
      button.addEventListener("click", () => { choose({ sort: by === name && !down ? name + " down" : name }); pick("rows").querySelector(`[data-sort="${name}"]`).focus(); });
      cell.append(button);
      head.append(cell);
    });
    rows.slice(0, ROWS).forEach((row) => {
      const line = body.insertRow();
      Object.keys(HEADS).forEach((name) => { line.insertCell().textContent = row[name] === null ? "–" : typeof row[name] === "number" ? digits(row[name]) + (name === "theta" && row.extrapolated ? " †" : "") : name === "variant" ? row[name] : words(row[name]); });
    });
    pick("rows").replaceChildren(table);
    pick("rows").hidden = false;
    return { rows: () => rows, notes: [`θ is the median of ${data.im}.`, rows.some((row) => row.extrapolated) && `†: extrapolated, ${OUTSIDE}.`, !rows.length && "No fit by this method for these variants.", rows.length > ROWS && `The first ${ROWS} of ${rows.length} rows are shown; the CSV has all.`] };
  }
