/* A run that goes on: frames and numbers come as events of the server (robot/view/browser.py). */
"use strict";
(() => {
  const MOST_FRAMES = 6000, BEHIND_S = 0.4, JUMP_S = 3;
  const figure = document.querySelector("figure.replay"), state = document.getElementById("state");
  const numbers = document.getElementById("numbers"), button = document.getElementById("live");
  let replay = null, live = true;

  function follow(on) {
    live = on;
    button.setAttribute("aria-pressed", String(on));
    if (on && replay) replay.play(false);
  }
  button.addEventListener("click", () => follow(!live));

  const source = new EventSource("events");
  source.onmessage = (event) => {
    const told = JSON.parse(event.data);
    numbers.textContent = told.lines.join("\n");
    state.textContent = "live";
    if (!told.frames) return;
    if (replay) { replay.add(told.frames, MOST_FRAMES); return; }
    figure.querySelector("script").textContent = JSON.stringify(told.frames);
    replay = figure.replay = new bigant.Replay(figure);
    replay.slider.addEventListener("input", () => follow(false));
    replay.button.addEventListener("click", () => follow(false), true);
  };
  source.addEventListener("end", () => {
    source.close();
    state.textContent = "the run has ended; what came in can still be played";
  });
  source.onerror = () => { state.textContent = "no connection; trying again"; };

  /* Frames come in pieces: the picture goes on smoothly a little behind the newest one. */
  let before = performance.now();
  function step(now) {
    const seconds = (now - before) / 1000;
    before = now;
    if (replay && live && !replay.playing) {
      const target = replay.newest - BEHIND_S, apart = target - replay.t;
      const t = Math.abs(apart) > JUMP_S ? target : Math.min(replay.newest, replay.t + seconds * Math.max(0, 1 + apart));
      if (t !== replay.t) replay.seek(t);
    }
    requestAnimationFrame(step);
  }
  requestAnimationFrame(step);
})();
