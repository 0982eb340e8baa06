"use strict";
// Plays the films of a page: each <figure class="film"> holds its numbers as JSON (see packing.py).  picture.js draws them.
(() => {
  const STRETCH = 0.7, SHADES = 200, GROWTH_SECONDS = 6, SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
  const quiet = window.matchMedia("(prefers-reduced-motion: reduce)");

  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // Second differences, cell by cell, low bytes before high ones, as positions [step * 2 * cells + axis * cells + cell] in metres.
  function positions(part, bytes, steps) {
    const [start, size] = part.position, half = size / 2, width = 2 * part.cells, out = new Float32Array(steps * width);
    for (let k = 0, at = start; k < width; k++) {
      let value = part.first[k], speed = 0;
      for (let t = 0; t < steps; t++, at++) {
        const folded = bytes[at] | (bytes[at + half] << 8);
        speed += (folded >>> 1) ^ -(folded & 1);
        value += speed;
        out[t * width + k] = value / part.scale;
      }
    }
    return out;
  }

  function levels(part, bytes, steps) {
    const out = new Int8Array(steps * part.cells);
    for (let k = 0, at = part.activation[0]; k < part.cells; k++) {
      for (let t = 0, value = 0; t < steps; t++, at++) out[t * part.cells + k] = value = (value + bytes[at]) << 24 >> 24;
    }
    return out;
  }

  function shades(stops) {
    return Array.from({ length: 2 * SHADES + 1 }, (_, k) => {
      const a = k / SHADES - 1, x = (Math.sign(a) * Math.abs(a) ** STRETCH + 1) / 2 * (stops.length - 1);
      const i = Math.min(Math.floor(x), stops.length - 2), f = x - i;
      return stops[i].map((value, channel) => Math.round(value + f * (stops[i + 1][channel] - value)));
    });
  }

  function element(name, properties = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(properties)) key in made ? made[key] = value : made.setAttribute(key, value);
    made.append(...children);
    return made;
  }

  function choice(label, options, chosen, changed) {
    const box = element("select", {}, ...options.map(([value, text]) => element("option", { value, textContent: text, selected: value === chosen })));
    box.addEventListener("change", () => changed(box.value));
    return element("label", {}, label, box);
  }

  class Film extends Picture {
    constructor(figure, film, bytes) {
      super();
      Object.assign(this, { figure, film, grow: film.growth, life: film.life, colours: film.palette, speed: 1, playing: false });
      this.grown = this.grow ? this.grow.steps.length : 0;
      this.lived = this.life ? this.life.milliseconds.length : 0;
      this.count = this.grown + this.lived;
      if (this.grow) this.growth = { at: positions(this.grow, bytes, this.grown), level: levels(this.grow, bytes, this.grown) };
      if (this.life) {
        this.body = { at: positions(this.life, bytes, this.lived), level: levels(this.life, bytes, this.lived) };
        const bits = this.life.contact;
        this.touch = bits ? bytes.subarray(bits[0], bits[0] + bits[1]) : null;
        this.chambers = this.life.chambers;
        this.measure();
      }
      this.shades = Object.fromEntries(Object.entries(film.palettes).map(([name, one]) => [name, shades(one.stops)]));
      this.clock = this.times();
      this.aims = Boolean(this.life) && this.life.target.some((change) => change[1] !== null);
      this.view = this.aims ? "whole" : "follow";
      this.alone = "alone" in figure.dataset;
      this.build();
      const moves = this.alone && !quiet.matches;
      this.go(moves || !this.lived ? 0 : this.grown);
      if (moves) this.play();
      figure.dataset.ready = "";
    }

    // Seconds at which each frame is shown: growth quickly, then life as it was, holes cut short.
    times() {
      const clock = [], pace = Math.min(1 / 60, GROWTH_SECONDS / Math.max(this.grown, 1));
      for (let k = 0; k < this.grown; k++) clock.push(k * pace);
      let now = this.grown ? this.grown * pace + 0.3 : 0;
      for (let k = 0; k < this.lived; k++) {
        if (k) now += Math.min(1, (this.life.milliseconds[k] - this.life.milliseconds[k - 1]) / 1000);
        clock.push(now);
      }
      return clock;
    }

    build() {
      const { figure } = this;
      this.canvas = element("canvas", { tabIndex: 0, role: "img", "aria-label": `${this.film.label}. Space plays and pauses, arrow keys step.` });
      this.button = element("button", { type: "button" });
      this.button.addEventListener("click", () => this.toggle());
      this.range = element("input", { type: "range", min: 0, max: this.count - 1, step: 1, value: 0, "aria-label": "moment of the film" });
      this.range.addEventListener("input", () => { this.pause(); this.go(Number(this.range.value)); });
      this.told = element("output", { "aria-live": "off" });
      this.spoken = element("span", { className: "spoken", role: "status" });
      this.legend = element("p", { className: "legend" });
      const views = [["follow", "body"], ["whole", "whole way"]];
      const speeds = SPEEDS.map((value) => [String(value), `${value} ×`]);
      const colours = [["safe", "for all eyes"], ["paper", "of the paper"]];
      const redraw = () => this.go(this.step);
      this.speeds = choice("speed", speeds, "1", (value) => { this.speed = Number(value); this.restart(); });
      this.options = element("div", { className: "controls options" }, this.speeds);
      if (this.life) this.options.append(choice("view", views, this.view, (value) => { this.view = value; redraw(); }));
      this.options.append(choice("colours", colours, this.colours, (value) => { this.colours = value; this.explain(); redraw(); }));
      figure.append(this.canvas, element("div", { className: "controls" }, this.button, this.range, this.told), this.options, this.legend);
      figure.append(element("p", { className: "keys", textContent: "Space plays and pauses; ← and → step, with Shift by 20; Home, End; , and . change the speed." }));
      figure.append(this.spoken);
      this.explain();
      this.label();
      (this.alone ? document : figure).addEventListener("keydown", (event) => this.key(event));
      this.canvas.addEventListener("click", () => this.toggle());
      new ResizeObserver(() => this.step !== undefined && this.draw()).observe(this.canvas);
    }

    explain() {
      const one = this.film.palettes[this.colours], all = this.shades[this.colours];
      const stops = Array.from({ length: 21 }, (_, k) => `rgb(${all[k * SHADES / 10]})`).join(",");
      this.legend.replaceChildren(
        `muscles e − c: −1 ${one.contracting}, contracting`, element("i", { style: `background:linear-gradient(90deg,${stops})`, "aria-hidden": "true" }),
        `${one.expanding}, expanding +1; ${one.rest} at rest. Black dot: centre of mass.${this.touch ? " Triangles: cells that touch." : ""}${this.aims ? " Star: target." : ""}`);
    }

    key(event) {
      const name = event.target.tagName;
      if (event.ctrlKey || event.metaKey || event.altKey || name === "SELECT" || name === "SUMMARY" || name === "A") return;
      if (event.target === this.range && event.key !== " " && event.key !== "," && event.key !== ".") return;
      const by = event.shiftKey ? 20 : 1, speed = SPEEDS.indexOf(this.speed);
      if (event.key === " ") { if (name === "BUTTON") return; this.toggle(); }
      else if (event.key === "ArrowRight") { this.pause(); this.go(this.step + by); }
      else if (event.key === "ArrowLeft") { this.pause(); this.go(this.step - by); }
      else if (event.key === "Home") { this.pause(); this.go(0); }
      else if (event.key === "End") { this.pause(); this.go(this.count - 1); }
      else if (event.key === "," || event.key === ".") {
        this.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, speed + (event.key === "." ? 1 : -1)))];
        this.speeds.querySelector("select").value = String(this.speed);
        this.restart();
      } else return;
      event.preventDefault();
    }

    toggle() { this.playing ? this.pause() : this.play(); }

    play() {
      if (this.step >= this.count - 1) this.go(0);
      this.playing = true;
      this.label();
      this.restart();
      const tick = (now) => {
        if (!this.playing) return;
        const at = this.from + (now - this.since) / 1000 * this.speed;
        let step = this.step;
        while (step < this.count - 1 && this.clock[step + 1] <= at) step++;
        if (step !== this.step) this.go(step);
        if (step >= this.count - 1) return this.pause();
        requestAnimationFrame(tick);
      };
      requestAnimationFrame(tick);
    }

    restart() { this.from = this.clock[this.step]; this.since = performance.now(); }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      this.label();
      this.spoken.textContent = `paused at ${this.words()}`;
    }

    label() {
      this.button.textContent = this.playing ? "Pause" : "Play";
      this.figure.dataset.playing = this.playing;
    }

    words() {
      if (this.step < this.grown) return `growth, step ${this.grow.steps[this.step]}`;
      return `${(this.life.milliseconds[this.step - this.grown] / 1000).toFixed(2)} s`;
    }

    go(step) {
      this.step = Math.max(0, Math.min(this.count - 1, step));
      this.range.value = this.step;
      const last = this.lived ? ` of ${(this.life.milliseconds[this.lived - 1] / 1000).toFixed(1)} s` : "";
      this.told.textContent = this.words() + (this.step < this.grown ? "" : last);
      this.range.setAttribute("aria-valuetext", this.words());
      this.figure.dataset.step = this.step;
      this.draw();
    }
  }

  async function start(figure) {
    try {
      const film = JSON.parse(figure.querySelector("script").textContent);
      figure.film = new Film(figure, film, await inflate(film.data));
    } catch (error) {
      const why = window.DecompressionStream ? error.message : "this browser is too old: use one of 2023 or later";
      figure.append(element("p", { className: "about", role: "alert", textContent: `The film cannot be shown: ${why}.` }));
      if (window.DecompressionStream) console.error(error);
    }
  }
  document.querySelectorAll("figure.film").forEach(start);
})();
