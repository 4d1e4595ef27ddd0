/* Causes of a diagnosis, each switched on and off: the curves and the number show what is left without it.
   Python (robot/gap_report/page.py) gives the prediction with each set of causes. */
"use strict";
(() => {
  const box = document.querySelector(".switches");
  const told = JSON.parse(box.querySelector("script").textContent);
  const curves = told.curves.map(bigant.floats), places = [...document.querySelectorAll("[data-trace]")];
  const wanted = told.causes.map(() => true);
  const label = document.createElement("p"), bar = document.createElement("div"), words = document.createElement("p");
  label.textContent = "Switch each cause on and off:";
  bar.className = "legend";
  words.className = "left";
  words.setAttribute("aria-live", "polite");
  const shown = (rms) => rms === null ? "not known (the simulation breaks down)" : rms.toFixed(2);
  const floor = told.rms[told.sets.findIndex((one) => one.length === 0)];

  /* The number of the set that is switched on; -1 where it was not predicted. */
  function chosen() {
    const on = told.causes.map((_, k) => k).filter((k) => wanted[k]).join();
    return told.sets.findIndex((one) => one.join() === on);
  }

  function put(figure, number, set) {
    const count = curves[number].length / told.sets.length;
    for (const one of bigant.plots) if (one.figure === figure) {
      for (const renderer of one.model.renderers) if (renderer.name === told.curve) {
        const { x } = renderer.data_source.data;
        renderer.data_source.data = { x, y: curves[number].slice(set * count, (set + 1) * count) };
      }
    }
  }

  function update() {
    const set = chosen();
    if (set < 0) {
      words.textContent = "This set of causes was not simulated: all, none, each one alone, and all but one were.";
      return;
    }
    words.textContent = `RMS difference: ${shown(floor)} without any cause, ${shown(told.rms[set])} with those that are on; `
      + "1 is the baseline, without a gap.";
    places.forEach((place, number) => put(place.querySelector("figure"), number, set));
  }

  told.causes.forEach((name, k) => {
    const one = document.createElement("label"), tick = document.createElement("input");
    tick.type = "checkbox";
    tick.checked = true;
    tick.addEventListener("change", () => { wanted[k] = tick.checked; update(); });
    one.append(tick, name);
    bar.append(one);
  });
  box.append(label, bar, words);
  update();
  document.addEventListener("drawn", update);  // a plot that is drawn later takes what is switched on
})();
