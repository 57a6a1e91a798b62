// Show one figure at a time. The search of the browser finds and shows the others (beforematch).
(() => {
  const figures = [...document.querySelectorAll("#figures figure")];
  const pick = (name) => document.getElementById("gallery-" + name);
  const names = ["model", "section", "item"];
  const unique = (list) => [...new Set(list)];
  const models = unique(figures.map((figure) => figure.dataset.model)).filter(Boolean);
  let shown = figures[0];
  if (!shown) return;
  const ofModel = (model) => figures.filter((figure) => !figure.dataset.model || figure.dataset.model === model);
  function fill(name, values, chosen) {
    pick(name).replaceChildren(...values.map((value) => new Option(value, value, false, value === chosen)));
  }
  function show(figure) {
    const model = figure.dataset.model || pick("model").value || models[0];
    const near = ofModel(model), { section, item } = figure.dataset;
    shown = figure;
    fill("model", models, model);
    fill("section", unique(near.map((each) => each.dataset.section)), section);
    fill("item", near.filter((each) => each.dataset.section === section).map((each) => each.dataset.item), item);
    pick("model").disabled = models.length < 2;
    pick("item").disabled = pick("item").length < 2;
    pick("model").title = pick("model").disabled ? "The study has one bridge with one abutment model" : "";
    pick("item").title = pick("item").disabled ? "There is one figure of this quantity" : "";
    figures.forEach((each) => { each.hidden = each === figure ? false : "until-found"; });
    pick("count").textContent = `figure ${figures.indexOf(figure) + 1} of ${figures.length}`;
  }
  function choose(changed) {
    const [model, section, item] = names.map((name) => pick(name).value);
    const near = ofModel(model), same = near.filter((each) => each.dataset.section === section);
    show(same.find((each) => changed !== "section" && each.dataset.item === item) || same[0] || near[0]);
    history.replaceState(null, "", "#" + shown.id);
  }
  function step(by) {
    show(figures[(figures.indexOf(shown) + by + figures.length) % figures.length]);
    history.replaceState(null, "", "#" + shown.id);
  }
  function fromAddress() {
    const wanted = figures.find((figure) => "#" + figure.id === location.hash);
    if (wanted) { show(wanted); wanted.scrollIntoView(); }
  }
  names.forEach((name) => pick(name).addEventListener("change", () => choose(name)));
  pick("back").addEventListener("click", () => step(-1));
  pick("next").addEventListener("click", () => step(1));
  figures.forEach((figure) => figure.addEventListener("beforematch", () => show(figure)));
  window.addEventListener("hashchange", fromAddress);
  window.addEventListener("beforeprint", () => figures.forEach((figure) => { figure.hidden = false; }));
  window.addEventListener("afterprint", () => show(shown));
  pick("controls").hidden = false;
  show(shown);
  fromAddress();
})();
