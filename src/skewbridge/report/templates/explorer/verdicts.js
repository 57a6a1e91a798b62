  // ---- effects: margins, verdicts and texts ----
  const RATIO = "ratio";
  // lower and upper margin of an effect, as ln ratio or difference
  function marginsOf(effect, factor) {
    if (effect.judged_by !== RATIO) return [-factor * effect.margin, factor * effect.margin];
    const margin = Math.min(0.95, factor * effect.margin);
    return [Math.log1p(-margin), Math.log1p(margin)];
  }
  // verdicts hold jointly within a family (Holm): computed with the tables at each factor on the margins
  const styleOf = (effect, factor) => effect.styles[data.factors.indexOf(factor)];
  function signed(value, unit) {
    if (!Number.isFinite(value)) return "–";
    const size = Math.abs(value), places = unit === "in" ? 3 : size > 9.5 ? 0 : size > 0.95 || unit === "%" ? 1 : 2;
    const text = size.toFixed(places);
    return (value < 0 && Number(text) !== 0 ? "-" : "+") + text + (unit ? " " + unit : "");
  }
  // unit of the change of an effect in the chosen units, and the factor to it
  const shownUnit = (effect, units) => (effect.judged_by === RATIO ? { unit: "%", by: 100 } : inUnits(effect.unit, units));
  const asChange = (effect, value) => (value === null ? NaN : effect.judged_by === RATIO ? value - 1 : value);
  const nameOf = (effect) => data.demands[effect.demand]?.label ?? data.states[effect.demand];
  function changeText(effect, units) {
    if (effect.status === "not_estimable") return "not estimable";
    const { unit, by } = shownUnit(effect, units);
    return signed(by * asChange(effect, effect.value), unit);
  }
  function intervalText(effect, units) {
    const { unit, by } = shownUnit(effect, units);
    if (effect.low === null || effect.high === null) return "no interval";
    return `${signed(by * asChange(effect, effect.low), unit).replace(" " + unit, "")} to ${signed(by * asChange(effect, effect.high), unit)}`;
  }
  function marginText(effects, factor, units) {
    const apart = new Map(effects.map((effect) => [effect.judged_by + effect.unit + effect.margin, effect]));
    const texts = [...apart.values()].map((effect) => { const { unit, by } = shownUnit(effect, units); return `±${+(by * factor * effect.margin).toPrecision(3)} ${unit}`; });
    return unique(texts).join(", ");
  }
  const otherAxes = (effect) => data.axes.filter((axis, place) => axis.name !== effect.axis && effect.values && effect.values[place] !== null);
  // values of the other axes; cached, because moving the slider of a threshold needs thousands
  const placeText = (effect) => (effect.place ??= otherAxes(effect).map((axis) => textOf(axis, effect.values[axisAt[axis.name]], axis.named)).join(", "));
  // the chosen effects: pooled over all variants, or of the pairs at the chosen values
  const chosenEffects = (chosen) => data.effects.filter((effect) => data.models[effect.model] === chosen.model && effect.quantity === chosen.quantity && (chosen.scope === "pooled" ? !effect.values : effect.values && matches(effect.values, chosen, effect.axis)));
