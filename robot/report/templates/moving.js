/* Plots of Bokeh in place of still pictures, each once it comes near the screen; one clock for all that has a time.
   Python (robot/report/moving.py) gives each figure as JSON beside its still picture. Without this script, and
   on paper, the still picture stays. */
"use strict";
const bigant = {
  plots: [],            // every panel that is drawn: {figure, name, model, view, time, stretch}
  listeners: [],        // called with the time of the cursor [s]
  time: null,
  /* Put the cursor of a panel where the time is; it lies over the plot, which need not be drawn again. */
  place_cursor(one) {
    const { start, end } = one.model.x_range, box = one.view.frame.bbox;
    const share = (bigant.time - start) / (end - start);
    one.cursor.hidden = bigant.time === null || !(share >= 0 && share <= 1);
    Object.assign(one.cursor.style, { top: `${box.top}px`, height: `${box.height}px`, left: `${box.left + share * box.width}px` });
  },

  /* Arrays that robot/report/packed.py made text of. */
  bytes: (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer,
  floats: (text) => new Float32Array(bigant.bytes(text)).map((x) => (x > 1e29 ? NaN : x)),
  whole: (one) => Float32Array.from(new Int16Array(bigant.bytes(one.data)), (x) => (x === -32768 ? NaN : x * one.scale)),
  colour: (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim(),

  /* Move the cursor of all curves over time, and whoever listens, to a time [s]. */
  seek(t, from = null) {
    bigant.time = t;
    for (const one of bigant.plots) if (one.time) bigant.place_cursor(one);
    for (const listen of bigant.listeners) if (listen !== from) listen(t);
  },
};

(() => {
  const BLACK = "#000000";
  let linking = false;

  /* Colours of the page, light or dark, for a plot. */
  function paint(model) {
    const ink = bigant.colour("--ink"), faint = bigant.colour("--faint"), line = bigant.colour("--line");
    for (const axis of [...model.above, ...model.below, ...model.left, ...model.right]) {
      if (axis.name === "colours") {
        Object.assign(axis, { background_fill_alpha: 0, major_label_text_color: faint, title_text_color: faint });
        continue;
      }
      if (!("major_label_text_color" in axis.properties)) continue;
      Object.assign(axis, { major_label_text_color: faint, axis_label_text_color: faint,
                            axis_line_color: faint, major_tick_line_color: faint });
    }
    for (const one of model.center) {
      if ("grid_line_color" in one.properties) one.grid_line_color = line;
      if ("text_color" in one.properties) one.text_color = ink;
      if (one.type === "Arrow") {
        one.line_color = one.end.fill_color = one.end.line_color = ink;
      }
      for (const key of ["line_color"])
        if (key in one.properties && [BLACK, one.was_black].includes(one[key])) {
          one[key] = one.was_black = ink;
        }
    }
    if (model.title) model.title.text_color = ink;
    for (const renderer of model.renderers) {
      for (const glyph of [renderer.glyph, renderer.nonselection_glyph, renderer.muted_glyph]) {
        for (const key of ["line_color", "fill_color"]) {
          if (!glyph || !glyph.properties || !(key in glyph.properties)) continue;  // of a map of values it is a word
          const value = glyph[key] && glyph[key].value;
          if (value === BLACK || (value && value === glyph["black_" + key])) {
            glyph[key] = { value: ink };
            glyph["black_" + key] = ink;
          }
        }
      }
    }
  }

  /* Keep the share of a metre ahead to a metre aside that the still picture has. */
  function keep_stretch(one) {
    const box = one.view.frame.bbox, x = one.model.x_range, y = one.model.y_range;
    if (!one.stretch || !(box.width > 0)) return;
    const [left, right] = one.wanted_x, [low, high] = one.wanted_y;
    const x_per_px = (right - left) / box.width, y_per_px = (high - low) / box.height;
    const scale = Math.max(x_per_px, y_per_px * one.stretch);
    const half_x = scale * box.width / 2, half_y = scale / one.stretch * box.height / 2;
    x.setv({ start: (left + right) / 2 - half_x, end: (left + right) / 2 + half_x });
    y.setv({ start: (low + high) / 2 - half_y, end: (low + high) / 2 + half_y });
    x.reset_start = x.start; x.reset_end = x.end;
    y.reset_start = y.start; y.reset_end = y.end;
  }

  function linked(one) {
    const range = one.model.x_range;
    range.change.connect(() => {
      if (linking) return;
      linking = true;
      for (const other of bigant.plots) if (other !== one && other.time) {
        other.model.x_range.setv({ start: range.start, end: range.end });
      }
      linking = false;
      for (const other of bigant.plots) if (other.time) bigant.place_cursor(other);
    });
    const first = bigant.plots.find((other) => other.time && other !== one);
    if (first) range.setv({ start: first.model.x_range.start, end: first.model.x_range.end });
    one.model.on_event("tap", (event) => bigant.seek(event.x));
    one.cursor = document.createElement("div");
    one.cursor.className = "cursor";
    one.cell.append(one.cursor);
    bigant.place_cursor(one);
    new ResizeObserver(() => requestAnimationFrame(() => bigant.place_cursor(one))).observe(one.cell);
  }

  const short = (x) => String(Number(x.toPrecision(4)));

  /* The point of a curve nearest to a place: in time, or in the plane of a path. */
  function nearest(one, source, place) {
    const { x: xs, y: ys } = source.data, box = one.view.frame.bbox;
    const x_px = box.width / (one.model.x_range.end - one.model.x_range.start);
    const y_px = one.stretch ? box.height / (one.model.y_range.end - one.model.y_range.start) : 0;
    let best = { apart: Infinity };
    for (let k = 0; k < xs.length; k++) {
      const apart = Math.hypot(x_px * (xs[k] - place.x), y_px * (ys[k] - place.y));
      if (apart < best.apart) best = { apart, x: xs[k], y: ys[k] };
    }
    return best;
  }

  /* Values of the curves under the pointer, in a corner of the panel. */
  function add_readout(one) {
    const box = document.createElement("div");
    box.className = "readout";
    one.cell.append(box);
    one.model.on_event("mousemove", (place) => {
      const found = new Map();
      for (const renderer of one.model.renderers) {
        if (!renderer.visible || renderer.glyph.type !== "Line") continue;
        const point = nearest(one, renderer.data_source, place), name = renderer.name || one.labels[1];
        if (point.apart < 40 && !(found.has(name) && found.get(name).apart < point.apart)) found.set(name, point);
      }
      let points = [...found].sort((a, b) => a[1].apart - b[1].apart);
      if (one.stretch) points = points.slice(0, 1);
      const [x_label, y_label] = one.labels;
      box.textContent = !points.length ? "" : one.stretch
        ? points.map(([name, p]) => `${name}: ${x_label} ${short(p.x)}, ${y_label} ${short(p.y)}`).join("")
        : `${x_label} ${short(place.x)}: ` + points.map(([name, p]) => `${name} ${short(p.y)}`).join(", ");
    });
    one.cell.addEventListener("mouseleave", () => { box.textContent = ""; });
  }

  async function add_panel(figure, panel, grid, number) {
    const cell = document.createElement("div");
    grid.append(cell);
    const manager = await Bokeh.embed.embed_item(panel.item, cell);
    const view = manager.get_by_id(panel.item.root_id), model = view.model;
    const one = {
      figure, view, model, cell, labels: panel.labels, time: panel.time, stretch: panel.stretch, number,
      wanted_x: [model.x_range.start, model.x_range.end], wanted_y: [model.y_range.start, model.y_range.end],
    };
    paint(model);
    if (one.stretch) {
      keep_stretch(one);
      let width = 0;
      new ResizeObserver(() => {
        if (Math.abs(cell.clientWidth - width) > 1) { width = cell.clientWidth; requestAnimationFrame(() => keep_stretch(one)); }
      }).observe(cell);
    }
    if (one.time) linked(one);
    cell.addEventListener("dblclick", () => model.reset.emit());
    add_readout(one);
    bigant.plots.push(one);
  }

  /* Names of the curves, as buttons that hide and show them in all panels of a figure. */
  function legend(figure, names) {
    const bar = document.createElement("div");
    bar.className = "legend";
    for (const { name, colour, dash, shade } of names) {
      const button = document.createElement("button");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      const sample = document.createElement("i");
      sample.style.setProperty("--colour", colour === BLACK ? "var(--ink)" : colour);
      sample.className = shade ? "shade" : dash;
      button.append(sample, name);
      button.addEventListener("click", () => {
        const shown = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(shown));
        show(figure, name, shown);
      });
      bar.append(button);
    }
    return bar;
  }

  function show(figure, name, shown) {
    for (const one of bigant.plots) if (one.figure === figure) {
      for (const part of [...one.model.renderers, ...one.model.center]) {
        if (part.name === name) part.visible = shown;
      }
    }
  }
  bigant.show = show;

  async function start(figure) {
    const told = JSON.parse(figure.querySelector("script").textContent);
    const moving = document.createElement("div"), grid = document.createElement("div");
    moving.className = "moving";
    grid.className = "panels";
    grid.style.setProperty("--columns", told.columns);
    if (told.legend.length > 1) moving.append(legend(figure, told.legend));
    moving.append(grid);
    figure.append(moving);
    figure.classList.add("live");
    let number = 0;
    for (const panel of told.panels) await add_panel(figure, panel, grid, number++);
    figure.dispatchEvent(new CustomEvent("drawn", { bubbles: true }));
    figure.dataset.drawn = "yes";
  }

  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) {
      near.unobserve(entry.target);
      start(entry.target);
    }
  }, { rootMargin: "300px" });
  const figures = [...document.querySelectorAll("figure.plot")];
  for (const figure of figures) near.observe(figure);
  if (figures.length) {
    const hint = document.createElement("p");
    hint.className = "hint";
    hint.textContent = "Drag across a plot to zoom into it, double-click to go back; ctrl and the wheel zoom too. "
      + "Curves show their values under the pointer; a name hides its curve.";
    (figures[0].closest(".traces") || figures[0]).after(hint);
  }

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const one of bigant.plots) paint(one.model);
  });
})();
