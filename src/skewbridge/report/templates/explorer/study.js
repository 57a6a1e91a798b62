  // ---- the study: variants, runs and fits, indexed ----
  const data = JSON.parse(await unpacked("explorer-data"));
  const MOST = 24; // largest number of curves, variants or columns in a figure
  const unique = (list) => [...new Set(list)];
  const words = (text) => String(text).replaceAll("_", " ").replace(/\bdcr (\d)(\d\d)\b/, "DCR $1.$2");
  const variants = data.variants;
  const runs = data.runs;
  // rows of a table stored as column names and lists of values
  const records = (table) => table.rows.map((row, id) => ({ id, ...Object.fromEntries(table.columns.map((name, place) => [name, row[place]])) }));
  data.fits = records(data.fits);
  data.effects = records(data.effects);
  const rowsOf = variants.map(() => []);
  runs.variant.forEach((variant, row) => rowsOf[variant].push(row));
  const axisAt = Object.fromEntries(data.axes.map((axis, place) => [axis.name, place]));
  const textOf = (axis, value, texts = axis.texts) => texts[axis.values.indexOf(value)];
  const valueText = (name, value) => textOf(data.axes[axisAt[name]], value);
  const changeName = (row) => `${data.axes[axisAt[row.axis]].label} ${valueText(row.axis, row.from)} to ${valueText(row.axis, row.to)}`;

  data.effects.forEach((effect) => { effect.change = changeName(effect); });

  // whether the values of the axes are the chosen ones
  const matches = (values, chosen, skip) => data.axes.every((axis, place) => axis.name === skip || chosen[axis.name] === "all" || String(values[place]) === chosen[axis.name]);
  const chosenVariants = (chosen) => variants.map((_, place) => place).filter((place) => data.models[variants[place].model] === chosen.model && matches(variants[place].values, chosen));

  // a length, force or rotation in the chosen units
  function inUnits(unit, units) {
    const us = units === "us" ? data.us[unit] : undefined;
    return us ? { unit: us.unit, by: us.factor } : { unit, by: 1 };
  }
  function demandIn(name, units) {
    const known = data.demands[name], shown = inUnits(known.unit, units);
    return { by: shown.by, label: shown.unit === "-" ? known.label : `${known.label} (${shown.unit})` };
  }
  const digits = (value) => String(+value.toPrecision(4));
  const command = (row) => runs.key[row] && "skewbridge run --row " + runs.key[row];
  const loadingText = (row) => data.motions[runs.motion[row]] + (runs.status[row] ? ", " + words(data.statuses[runs.status[row]]) : "") + (runs.complete[row] ? "" : ", a lower bound");

  // pairs of runs under the same motion, of variants that differ in one axis only
  function pairsOf(effect) {
    const place = axisAt[effect.axis];
    const rest = (values) => values.filter((_, at) => at !== place).join("|");
    const own = variants.map((_, at) => at).filter((at) => variants[at].model === effect.model && (!effect.values || effect.values.every((value, axis) => axis === place || value === variants[at].values[axis])));
    const start = new Map(own.filter((at) => variants[at].values[place] === effect.from).map((at) => [rest(variants[at].values), at]));
    const found = [];
    own.filter((at) => variants[at].values[place] === effect.to && start.has(rest(variants[at].values))).forEach((to) => {
      const from = start.get(rest(variants[to].values));
      const byLoading = new Map(rowsOf[from].map((row) => [runs.loading[row], row]));
      found.push({ from, to, rows: rowsOf[to].filter((row) => byLoading.has(runs.loading[row])).map((row) => [byLoading.get(runs.loading[row]), row]) });
    });
    return found;
  }
