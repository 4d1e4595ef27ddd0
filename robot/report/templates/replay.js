/* The robot in three dimensions: orbit it with mouse or finger, play and scrub it; one clock with the curves.
   Python (robot/report/replay.py) gives arrays: whole numbers with a scale, or floats, in base64. */
"use strict";
(() => {
  const HOLDS = [120, 144, 168], SLIPS = [214, 39, 40], TRAIL_S = 3, GRID_M = 0.1;
  const MEASURED = "#0072B2", PREDICTED = "#D55E00", PATHS = { "true": "#0072B2", "estimator": "#009E73",
    "dead reckoning": "#D55E00" };
  const AXES = ["#CC3311", "#009E73", "#0077BB"];  // x, y, z
  const EDGES = [[0, 1], [1, 3], [3, 2], [2, 0], [4, 5], [5, 7], [7, 6], [6, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

  const { bytes, floats, whole } = bigant;

  function unpack(told) {
    const d = { ...told, t: floats(told.t), place: floats(told.place), turn: floats(told.turn),
      loaded: new Uint8Array(bytes(told.loaded)), paths: {} };
    for (const name of ["points", "feet", "slip", "measured", "predicted"]) d[name] = whole(told[name]);
    for (const [name, path] of Object.entries(told.paths)) d.paths[name] = floats(path);
    return d;
  }

  /* The frame before a time, and how far the next one has come. */
  function frame_at(t, times) {
    let low = 0, high = times.length - 1;
    if (t <= times[0]) return [0, 0];
    if (t >= times[high]) return [high, 0];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle; else high = middle;
    }
    return [low, (t - times[low]) / (times[high] - times[low])];
  }

  /* Row i of an array of so many columns, on the way to row i + 1. */
  function row(array, columns, i, share) {
    const out = array.slice(i * columns, (i + 1) * columns);
    if (share > 0) for (let k = 0; k < columns; k++) {
      const next = array[(i + 1) * columns + k];
      out[k] = Number.isNaN(next) ? out[k] : out[k] + share * (next - out[k]);
    }
    return out;
  }

  function rotation([x, y, z, w]) {
    const n = Math.hypot(x, y, z, w) || 1;
    [x, y, z, w] = Number.isNaN(n) ? [0, 0, 0, 1] : [x / n, y / n, z / n, w / n];
    return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
            2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
            2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
  }

  class Replay {
    constructor(figure) {
      this.figure = figure;
      this.d = unpack(JSON.parse(figure.querySelector("script").textContent));
      this.count = this.d.t.length;
      this.t = this.d.begin;
      this.view = { azimuth: -55, elevation: 28, zoom: 1 };
      this.speed = 1;
      this.playing = false;
      this.hidden = new Set();
      this.follow = true;
      this.build();
      this.resize();
    }

    build() {
      const add = (parent, kind, values = {}, words = "") => {
        const one = document.createElement(kind);
        Object.assign(one, values);
        if (words) one.textContent = words;
        parent.append(one);
        return one;
      };
      const box = add(this.figure, "div", { className: "moving" });
      this.canvas = add(box, "canvas", { tabIndex: 0 });
      this.canvas.setAttribute("aria-label", "The robot in three dimensions. Drag to turn it.");
      const bar = add(box, "div", { className: "controls" });
      this.button = add(bar, "button", { type: "button", className: "play" }, "Play");
      this.slider = add(bar, "input", { type: "range", min: this.d.t[0], max: this.d.t[this.count - 1], step: "any",
                                        value: this.t });
      this.slider.setAttribute("aria-label", "time");
      this.clock = add(bar, "output");
      const more = add(box, "div", { className: "legend" });
      const speed = add(more, "select");
      speed.setAttribute("aria-label", "speed");
      for (const times of [0.1, 0.25, 0.5, 1, 2, 5, 10]) add(speed, "option", { value: times, selected: times === 1 }, `${times} x`);
      speed.addEventListener("change", () => { this.speed = Number(speed.value); });
      const views = { "3-D": [-55, 28], above: [-90, 89.9], side: [-90, 4], behind: [180, 12] };
      for (const [name, [azimuth, elevation]] of Object.entries(views)) {
        add(more, "button", { type: "button" }, name).addEventListener("click", () => {
          Object.assign(this.view, { azimuth, elevation });
          this.draw();
        });
      }
      this.switch(more, "follow", () => { this.follow = !this.follow; });
      if (this.d.axes_m) this.switch(more, "axes", () => { if (!this.hidden.delete("axes")) this.hidden.add("axes"); });
      if (this.d.still) bar.hidden = speed.hidden = true;
      const colours = { "measured forces": MEASURED, "predicted forces": PREDICTED };
      for (const name of Object.keys(this.d.paths)) colours[`path: ${name}`] = PATHS[name];
      for (const [name, colour] of Object.entries(colours)) {
        const kind = name.split(" ")[0];
        if (kind in this.d && !this.d[kind].some((x) => !Number.isNaN(x))) continue;
        const button = this.switch(more, name, () => {
          if (!this.hidden.delete(name)) this.hidden.add(name);
        });
        const sample = add(button, "i");
        sample.style.setProperty("--colour", colour);
        button.prepend(sample);
      }
      this.button.addEventListener("click", () => this.play(!this.playing));
      this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
      this.canvas.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 0.1, ArrowLeft: -0.1 }[event.key];
        if (step) this.seek(this.t + step);
        else if (event.key === " ") this.play(!this.playing);
        else return;
        event.preventDefault();
      });
      this.listen = (t) => { this.place(t); };
      bigant.listeners.push(this.listen);
      this.orbit();
      this.figure.classList.add("live");
      new ResizeObserver(() => this.resize()).observe(box);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    }

    /* The time of the newest frame [s]. */
    get newest() { return this.d.t[this.count - 1]; }

    /* Frames that came later; of all, the last ones are kept. */
    add(told, most) {
      const more = unpack(told), drop = Math.max(0, this.count + more.t.length - most);
      const count = this.count;
      const joined = (own, other, rows) => {
        const columns = rows ? own.length / rows : 0, out = new own.constructor(own.length + other.length);
        out.set(own);
        out.set(other, own.length);
        return drop ? out.slice(drop * columns) : out;
      };
      for (const name of ["t", "place", "turn", "loaded", "slip", "points", "feet", "measured", "predicted"])
        this.d[name] = joined(this.d[name], more[name], count);
      const unknown = (rows) => new Float32Array(2 * rows).fill(NaN);
      for (const name of new Set([...Object.keys(this.d.paths), ...Object.keys(more.paths)]))
        this.d.paths[name] = joined(this.d.paths[name] || unknown(count), more.paths[name] || unknown(more.t.length), count);
      this.count = this.d.t.length;
      this.slider.min = this.d.t[0];
      this.slider.max = this.newest;
    }

    switch(parent, name, turn) {
      const button = document.createElement("button");
      button.type = "button";
      button.append(name);
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        button.setAttribute("aria-pressed", String(button.getAttribute("aria-pressed") !== "true"));
        turn();
        this.draw();
      });
      parent.append(button);
      return button;
    }

    orbit() {
      const at = new Map();
      let apart = 0;
      const spread = () => { const [a, b] = [...at.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
      this.canvas.addEventListener("pointerdown", (event) => {
        at.set(event.pointerId, [event.clientX, event.clientY]);
        this.canvas.setPointerCapture(event.pointerId);
        if (at.size === 2) apart = spread();
      });
      this.canvas.addEventListener("pointermove", (event) => {
        if (!at.has(event.pointerId)) return;
        const [x, y] = at.get(event.pointerId);
        at.set(event.pointerId, [event.clientX, event.clientY]);
        if (at.size === 2) {
          this.zoom(spread() / apart);
          apart = spread();
        } else {
          this.view.azimuth -= 0.5 * (event.clientX - x);
          this.view.elevation = Math.min(89.9, Math.max(-10, this.view.elevation + 0.4 * (event.clientY - y)));
        }
        this.draw();
      });
      for (const kind of ["pointerup", "pointercancel"]) this.canvas.addEventListener(kind, (event) => at.delete(event.pointerId));
      this.canvas.addEventListener("wheel", (event) => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        this.zoom(Math.exp(-0.002 * event.deltaY));
        this.draw();
      }, { passive: false });
    }

    zoom(times) { this.view.zoom = Math.min(20, Math.max(0.05, this.view.zoom * times)); }

    /* Move to a time [s], and the cursors of the curves with it. */
    seek(t) {
      this.place(t);
      bigant.seek(this.t, this.listen);
    }

    place(t) {
      this.t = Math.min(this.d.t[this.count - 1], Math.max(this.d.t[0], t));
      this.slider.value = this.t;
      this.draw();
    }

    play(on) {
      this.playing = on;
      this.button.textContent = on ? "Pause" : "Play";
      if (!on) return;
      if (this.t >= this.d.t[this.count - 1]) this.seek(this.d.t[0]);
      let before = performance.now();
      const step = (now) => {
        if (!this.playing) return;
        this.seek(this.t + this.speed * (now - before) / 1000);
        before = now;
        if (this.t >= this.newest && this.d.cycle_s) this.seek(this.d.t[0]);  // a cycle goes round
        if (this.t >= this.newest) this.play(false);
        else requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }

    resize() {
      const width = this.canvas.parentElement.clientWidth;
      if (!width) return;
      const height = Math.round(Math.min(0.55 * width + 60, 0.6 * innerHeight, 460));
      this.canvas.style.height = `${height}px`;
      this.canvas.width = width * devicePixelRatio;
      this.canvas.height = height * devicePixelRatio;
      this.draw();
    }

    /* What is seen at the time: places in the world, feet first. Tests read it. */
    pose() {
      const d = this.d, [i, share] = frame_at(this.t, d.t), legs = d.names.length;
      const turn = rotation(row(d.turn, 4, i, share)), place = row(d.place, 3, i, share).map((x) => x || 0);
      const world = (x, y, z) => [turn[0] * x + turn[1] * y + turn[2] * z + place[0],
        turn[3] * x + turn[4] * y + turn[5] * z + place[1], turn[6] * x + turn[7] * y + turn[8] * z + place[2]];
      const places = (values) => Array.from({ length: values.length / 3 }, (_, k) =>
        world(values[3 * k], values[3 * k + 1], values[3 * k + 2]));
      const feet = row(d.feet, 3 * legs, i, share);
      const arrows = {};
      for (const kind of ["measured", "predicted"]) {
        const force = row(d[kind], 3 * legs, i, share);
        arrows[kind] = places(feet.map((x, k) => x + d.metres_per_newton * force[k]));
      }
      const columns = d.points.length / this.count;
      return { i, place, world, feet: places(feet), points: places(row(d.points, columns, i, share)), arrows,
               loaded: d.loaded.slice(i * legs, (i + 1) * legs) };
    }

    draw() {
      if (!this.canvas.width) return;
      const d = this.d, now = this.pose(), { azimuth, elevation, zoom } = this.view;
      const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
      const context = this.canvas.getContext("2d"), { width, height } = this.canvas;
      const size = 1.7 * Math.hypot(d.box[3], d.box[4], d.box[5]) + 0.1;
      const scale = zoom * Math.min(width, 1.6 * height) / size;
      const centre = this.follow ? now.place : d.place.slice(0, 3).map((x) => x || 0);
      const seen = ([x, y, z]) => {
        const px = x - centre[0], py = y - centre[1], pz = z - centre[2];
        const right = -Math.sin(a) * px + Math.cos(a) * py, away = -Math.cos(a) * px - Math.sin(a) * py;
        return [width / 2 + scale * right, 0.47 * height - scale * (Math.cos(e) * pz + Math.sin(e) * away)];
      };
      const ink = bigant.colour("--ink"), faint = bigant.colour("--faint"), line = bigant.colour("--line");
      const dpr = devicePixelRatio;
      const stroke = (places, colour, wide, alpha = 1) => {
        context.beginPath();
        let on = false;
        for (const place of places) {
          const [x, y] = seen(place);
          if (Number.isNaN(x + y)) { on = false; continue; }
          if (on) context.lineTo(x, y); else context.moveTo(x, y);
          on = true;
        }
        Object.assign(context, { strokeStyle: colour, lineWidth: wide * dpr, globalAlpha: alpha, lineJoin: "round", lineCap: "round" });
        context.stroke();
        context.globalAlpha = 1;
      };
      context.clearRect(0, 0, width, height);

      // ground: a grid of 0.1 m around the middle of the view
      const reach = Math.ceil(0.8 * size / zoom / GRID_M), gx = Math.round(centre[0] / GRID_M), gy = Math.round(centre[1] / GRID_M);
      for (let k = -reach; k <= reach && reach < 200; k++) {
        stroke([[(gx + k) * GRID_M, (gy - reach) * GRID_M, 0], [(gx + k) * GRID_M, (gy + reach) * GRID_M, 0]], line, 1);
        stroke([[(gx - reach) * GRID_M, (gy + k) * GRID_M, 0], [(gx + reach) * GRID_M, (gy + k) * GRID_M, 0]], line, 1);
      }
      for (const [name, path] of Object.entries(d.paths)) {
        if (this.hidden.has(`path: ${name}`)) continue;
        const places = Array.from({ length: path.length / 2 }, (_, k) => [path[2 * k], path[2 * k + 1], 0]);
        stroke(places, PATHS[name], 1, 0.35);
        stroke(places.slice(0, now.i + 1), PATHS[name], 2);
      }
      this.trails(now, stroke);

      const [cx, cy, cz, lx, ly, lz] = d.box;
      const corners = Array.from({ length: 8 }, (_, k) => now.world(cx + lx * ((k >> 2 & 1) - 0.5), cy + ly * ((k >> 1 & 1) - 0.5), cz + lz * ((k & 1) - 0.5)));
      for (const [from, to] of EDGES) stroke([corners[from], corners[to]], ink, 1.5, 0.8);
      stroke([now.world(cx, cy, cz), now.world(cx + 0.65 * lx, cy, cz)], ink, 2);  // ahead
      for (const [leg, begin, count] of d.strips) stroke(now.points.slice(begin, begin + count), ink, 2.5);
      if (d.axes_m && !this.hidden.has("axes")) this.axes(now, seen, stroke, context);
      now.feet.forEach((foot, leg) => {
        const [x, y] = seen(foot);
        if (Number.isNaN(x + y)) return;
        context.beginPath();
        context.arc(x, y, (now.loaded[leg] ? 4.5 : 3) * dpr, 0, 7);
        context.fillStyle = !now.loaded[leg] ? faint
          : this.slip_colour((d.slip[now.i * d.names.length + leg] - d.red_from_to[0]) / (d.red_from_to[1] - d.red_from_to[0]));
        context.fill();
        context.fillStyle = faint;
        context.font = `${11 * dpr}px system-ui, sans-serif`;
        context.fillText(d.names[leg], x + 6 * dpr, y + 12 * dpr);
      });
      for (const [kind, colour] of [["measured", MEASURED], ["predicted", PREDICTED]]) {
        if (this.hidden.has(`${kind} forces`)) continue;
        now.arrows[kind].forEach((tip, leg) => {
          const foot = now.feet[leg];
          if (!(Math.hypot(tip[0] - foot[0], tip[1] - foot[1], tip[2] - foot[2]) > d.least_n * d.metres_per_newton)) return;
          stroke([foot, tip], colour, kind === "measured" ? 3.5 : 1.8);
          const [x, y] = seen(tip), [x0, y0] = seen(foot), along = Math.atan2(y - y0, x - x0);
          context.beginPath();
          context.moveTo(x, y);
          for (const side of [2.6, -2.6]) context.lineTo(x + 8 * dpr * Math.cos(along + side), y + 8 * dpr * Math.sin(along + side));
          context.fillStyle = colour;
          context.fill();
        });
      }
      this.clock.textContent = d.cycle_s ? `phase ${(this.t / d.cycle_s).toFixed(2)}` : `${this.t.toFixed(2)} s`;
    }

    /* The body frame at its origin: x forward, y left, z up. */
    axes(now, seen, stroke, context) {
      [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, along], k) => {
        const tip = now.world(...along.map((one) => one * this.d.axes_m));
        stroke([now.world(0, 0, 0), tip], AXES[k], 2.2);
        context.fillStyle = AXES[k];
        context.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
        const [x, y] = seen(tip);
        context.fillText(name, x + 4 * devicePixelRatio, y - 3 * devicePixelRatio);
      });
    }

    /* Where each foot stood on the ground in the last seconds: grey where it held, red where it slipped. */
    trails(now, stroke) {
      const d = this.d, legs = d.names.length, from = frame_at(this.t - TRAIL_S, d.t)[0], [least, full] = d.red_from_to;
      for (let leg = 0; leg < legs; leg++) {
        let before = null;
        for (let i = from; i <= now.i; i++) {
          let place = null;
          if (d.loaded[i * legs + leg]) {
            const turn = rotation(d.turn.slice(4 * i, 4 * i + 4)), at = d.place.slice(3 * i, 3 * i + 3);
            const [x, y, z] = d.feet.slice(3 * (i * legs + leg), 3 * (i * legs + leg) + 3);
            place = [turn[0] * x + turn[1] * y + turn[2] * z + at[0], turn[3] * x + turn[4] * y + turn[5] * z + at[1], 0];
          }
          if (place && before) stroke([before, place], this.slip_colour((d.slip[i * legs + leg] - least) / (full - least)), 3);
          before = place;
        }
      }
    }

    /* Grey for a foot that holds, red for one that slips, from 0 to 1. */
    slip_colour(share) {
      const red = Math.min(1, Math.max(0, share || 0));
      return `rgb(${HOLDS.map((grey, k) => Math.round(grey + red * (SLIPS[k] - grey))).join(",")})`;
    }
  }

  bigant.Replay = Replay;
  for (const figure of document.querySelectorAll("figure.replay"))
    if (figure.querySelector("script").textContent) figure.replay = new Replay(figure);  // else live.js does
})();
