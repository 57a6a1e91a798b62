  // ---- effects: what an interval says against a margin ----
  const RATIO = "ratio";
  // the margins of an effect around no change, on the scale of its verdict
  function marginsOf(effect, factor) {
    if (effect.judged_by !== RATIO) return [-factor * effect.margin, factor * effect.margin];
    const margin = Math.min(0.95, factor * effect.margin);
    return [Math.log1p(-margin), Math.log1p(margin)];
  }
  const onScale = (effect, value) => (value === null ? NaN : effect.judged_by === RATIO ? Math.log(value) : value);
  function styleOf(effect, factor) {
    const [below, above] = marginsOf(effect, factor);
    const [value, low, high] = [effect.value, effect.low, effect.high].map((end) => onScale(effect, end));
    if (high < below || low > above) {
      const size = Math.abs(value / (value < 0 ? below : above));
      return (high < below ? "lower" : "higher") + (1 + data.depths.filter((depth) => size >= depth).length);
    }
    if (low >= below && high <= above && effect.possible) return "within";
    return high < 0 ? "down" : low > 0 ? "up" : "undecided";
  }
  function signed(value, unit) {
    if (!Number.isFinite(value)) return "–";
    const size = Math.abs(value), places = unit === "in" ? 3 : size > 9.5 ? 0 : size > 0.95 || unit === "%" ? 1 : 2;
    const text = size.toFixed(places);
    return (value < 0 && Number(text) !== 0 ? "-" : "+") + text + (unit ? " " + unit : "");
  }
  // what is shown of an effect: factor and unit of its change in the chosen units
  const shownUnit = (effect, units) => (effect.judged_by === RATIO ? { unit: "%", by: 100 } : inUnits(effect.unit, units));
  const asChange = (effect, value) => (value === null ? NaN : effect.judged_by === RATIO ? value - 1 : value);
  function changeText(effect, units) {
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
    const told = [...apart.values()].map((effect) => { const { unit, by } = shownUnit(effect, units); return `±${+(by * factor * effect.margin).toPrecision(3)} ${unit}`; });
    return unique(told).join(", ");
  }
  const otherAxes = (effect) => data.axes.filter((axis, place) => axis.name !== effect.axis && effect.values && effect.values[place] !== null);
  // where a pair stands; thousands are asked for at every move of a slider
  const placeText = (effect) => (effect.place ??= otherAxes(effect).map((axis) => textOf(axis, effect.values[axisAt[axis.name]], axis.named)).join(", "));
  // the effects that are chosen: pooled over all variants, or those of the pairs at the chosen values
  const chosenEffects = (chosen) => data.effects.filter((effect) => data.models[effect.model] === chosen.model && (chosen.scope === "pooled" ? !effect.values : effect.values && matches(effect.values, chosen, effect.axis)));
