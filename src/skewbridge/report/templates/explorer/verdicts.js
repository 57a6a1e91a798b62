  // ---- effects: family-wise verdicts of intervals against margins ----
  const RATIO = "ratio";
  // lower and upper margin of an effect, as ln ratio or difference
  function marginsOf(effect, factor) {
    if (effect.judged_by !== RATIO) return [-factor * effect.margin, factor * effect.margin];
    const margin = Math.min(0.95, factor * effect.margin);
    return [Math.log1p(-margin), Math.log1p(margin)];
  }
  const onScale = (effect, value) => (value === null ? NaN : effect.judged_by === RATIO ? Math.log(value) : value);
  // families of effects whose verdicts hold jointly (Holm): same model, axis, scope and quantity, headline or not
  const families = new Map();
  data.effects.forEach((effect) => {
    const family = [effect.model, effect.axis, !effect.values, effect.quantity, effect.headline].join("/");
    if (!families.has(family)) families.set(family, []);
    families.get(family).push(effect);
  });
  // p-values of claims, adjusted after Holm; claims without a p-value are left out
  function adjusted(claims) {
    const ordered = claims.filter(({ p }) => Number.isFinite(p)).sort((a, b) => a.p - b.p);
    let largest = 0;
    return new Map(ordered.map(({ effect, p }, rank) => { largest = Math.max(largest, Math.min(1, p * (ordered.length - rank))); return [effect, largest]; }));
  }
  function claimsOf(effect, factor) {
    const [below, above] = marginsOf(effect, factor), [value, low, high] = [effect.value, effect.low, effect.high].map((end) => onScale(effect, end));
    if (!Number.isFinite(low) || !Number.isFinite(high)) return { effect, outside: NaN, inside: NaN, direction: NaN };
    const dof = Math.max(effect.dof, 1), t = studentQuantile(0.5 + 0.5 * effect.level, dof);
    const steps = (distance, error) => (distance === 0 ? 0 : distance / error);
    const isBelow = (limit) => student(steps(value - limit, (high - value) / t), dof), isAbove = (limit) => student(steps(limit - value, (value - low) / t), dof);
    return { effect, outside: Math.min(isBelow(below), isAbove(above)), inside: Math.max(isBelow(above), isAbove(below)), direction: Math.min(1, 2 * Math.min(isBelow(0), isAbove(0))) };
  }
  const styles = { factor: null, found: new Map() }; // styles of all effects at one factor on the margins
  function styleOf(effect, factor) {
    if (styles.factor !== factor) {
      styles.factor = factor;
      families.forEach((members) => {
        const claims = members.map((member) => claimsOf(member, factor));
        const [outside, inside, direction] = ["outside", "inside", "direction"].map((name) => adjusted(claims.map((claim) => ({ effect: claim.effect, p: claim[name] }))));
        members.forEach((member) => styles.found.set(member, styleIn(member, outside.get(member), inside.get(member), direction.get(member))));
      });
    }
    return styles.found.get(effect);
  }
  function styleIn(effect, outside, inside, direction) {
    if (effect.status === "not_estimable") return "not_estimable";
    const value = onScale(effect, effect.value), tail = 1 - effect.level;
    if (outside <= 0.5 * tail) return value < 0 ? "lower" : "higher";
    if (inside <= 0.5 * tail && effect.possible) return "within";
    if (direction <= tail) return value < 0 ? "down" : "up";
    return "undecided";
  }
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
  // values of the other axes; cached, because moving a slider needs thousands
  const placeText = (effect) => (effect.place ??= otherAxes(effect).map((axis) => textOf(axis, effect.values[axisAt[axis.name]], axis.named)).join(", "));
  // the chosen effects: pooled over all variants, or of the pairs at the chosen values
  const chosenEffects = (chosen) => data.effects.filter((effect) => data.models[effect.model] === chosen.model && effect.quantity === chosen.quantity && (chosen.scope === "pooled" ? !effect.values : effect.values && matches(effect.values, chosen, effect.axis)));
