"use strict";
// Plays the films of a page: each <figure class="film"> holds its numbers as JSON (see packing.py).
(() => {
  const INK = "rgb(38,43,54)", QUIET = "rgb(138,145,158)", PATH = "rgb(222,116,24)", TARGET = "rgb(132,92,196)";
  const STRETCH = 0.7, SHADES = 200, DOT = 3.5, GROWTH_SECONDS = 6, SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
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

  class Film {
    constructor(figure, film, bytes) {
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

    // Centres of mass, the way of the camera, and the rectangles that it must hold.
    measure() {
      const { cells } = this.life, at = this.body.at, centre = new Float64Array(2 * this.lived);
      const box = [Infinity, Infinity, -Infinity, -Infinity], reach = [0, 0];
      for (let t = 0; t < this.lived; t++) {
        for (let axis = 0; axis < 2; axis++) {
          const from = (2 * t + axis) * cells;
          let sum = 0;
          for (let k = 0; k < cells; k++) sum += at[from + k];
          centre[2 * t + axis] = sum / cells;
          for (let k = 0; k < cells; k++) {
            const x = at[from + k];
            box[axis] = Math.min(box[axis], x);
            box[axis + 2] = Math.max(box[axis + 2], x);
            reach[axis] = Math.max(reach[axis], Math.abs(x - centre[2 * t + axis]));
          }
        }
      }
      for (const [, x, y] of this.life.target) {
        if (x === null) continue;
        [box[0], box[1]] = [Math.min(box[0], x), Math.min(box[1], y)];
        [box[2], box[3]] = [Math.max(box[2], x), Math.max(box[3], y)];
      }
      const walks = this.life.surfaces.length > 0, camera = Float64Array.from(centre);
      const window = Math.round(Math.min(30, this.lived / 8));
      for (let round = 0; round < 2; round++) {
        const before = Float64Array.from(camera);
        for (let axis = 0; axis < 2; axis++) {
          for (let t = 0; t < this.lived; t++) {
            const near = Math.min(window, t, this.lived - 1 - t);
            let sum = 0;
            for (let d = -near; d <= near; d++) sum += before[2 * (t + d) + axis];
            camera[2 * t + axis] = sum / (2 * near + 1);
          }
        }
      }
      Object.assign(this, { centre, box, camera, walks, reach });
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

    // The rectangle (x, y of its middle, half width, half height, in metres) that the picture must hold.
    frame(centre) {
      if (this.step < this.grown) {
        let half = 2.5;
        const all = this.growth.at, { cells } = this.grow, last = (this.grown - 1) * 2 * cells;
        for (let axis = 0; axis < 2; axis++) {
          const row = all.subarray(last + axis * cells, last + (axis + 1) * cells);
          half = Math.max(half, (Math.max(...row) - Math.min(...row)) / 2 + 1);
        }
        return [centre[0], centre[1], half, half];
      }
      const [a, b, c, d] = this.box;
      if (this.view === "whole") return [(a + c) / 2, (b + d) / 2, (c - a) / 2 + 1, (d - b) / 2 + 1];
      const t = this.step - this.grown, spare = 1.3;
      const y = this.walks && d - b < 4 * this.reach[1] ? (b + d) / 2 - 0.3 : this.camera[2 * t + 1];
      return [this.camera[2 * t], y, this.reach[0] + spare, (y === this.camera[2 * t + 1] ? this.reach[1] : (d - b) / 2) + spare];
    }

    draw() {
      const ratio = window.devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
      if (!width || !height) return;
      if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
        [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      }
      const pen = this.canvas.getContext("2d"), grows = this.step < this.grown;
      const part = grows ? this.grow : this.life, from = grows ? this.growth : this.body, t = grows ? this.step : this.step - this.grown;
      const cells = grows ? part.count[t] : part.cells, x0 = t * 2 * part.cells, y0 = x0 + part.cells;
      let centre = grows ? [0, 0] : [this.centre[2 * t], this.centre[2 * t + 1]];
      if (grows) for (let k = 0; k < cells; k++) centre = [centre[0] + from.at[x0 + k] / cells, centre[1] + from.at[y0 + k] / cells];
      const [mx, my, halfx, halfy] = this.frame(centre), scale = Math.min(width / (2 * halfx), height / (2 * halfy), 90);
      const X = (x) => width / 2 + (x - mx) * scale, Y = (y) => height / 2 - (y - my) * scale;
      const x = (k) => X(from.at[x0 + k]), y = (k) => Y(from.at[y0 + k]);
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.fillStyle = "#fff";
      pen.fillRect(0, 0, width, height);
      this.grid(pen, width, height, scale, mx, my, X, Y);
      if (!grows) this.world(pen, width, height, scale, X, Y, t);
      const colour = this.shades[this.colours], tone = (k) => colour[Math.max(-100, Math.min(100, from.level[t * part.cells + k])) * SHADES / 100 + SHADES];
      if (!grows) {
        for (const chamber of this.chambers) {
          const mean = [0, 1, 2].map((c) => chamber.reduce((sum, k) => sum + tone(k)[c], 0) / chamber.length);
          pen.fillStyle = `rgb(${mean.map((value) => Math.round(0.6 * 255 + 0.4 * value))})`;
          pen.beginPath();
          chamber.forEach((k, i) => i ? pen.lineTo(x(k), y(k)) : pen.moveTo(x(k), y(k)));
          pen.fill();
        }
      }
      const thin = Math.max(0.5, Math.min(1.6, 0.045 * scale));
      for (let k = 0; k < cells; k++) {
        pen.beginPath();
        pen.arc(x(k), y(k), Math.max(0.5 * scale - 0.25 * thin, 1), 0, 2 * Math.PI);
        pen.fillStyle = `rgb(${tone(k)})`;
        pen.fill();
        pen.strokeStyle = "#fff";
        pen.lineWidth = 0.5 * thin;
        pen.stroke();
      }
      const pairs = grows ? part.graphs.reduce((held, graph) => graph[0] <= t ? graph : held, [0, []])[1] : part.springs;
      const lines = (list, size) => {
        pen.strokeStyle = INK;
        pen.lineWidth = size;
        pen.lineCap = "round";
        pen.beginPath();
        for (let k = 0; k < list.length; k += 2) {
          if (list[k] >= cells || list[k + 1] >= cells) continue;
          pen.moveTo(x(list[k]), y(list[k]));
          pen.lineTo(x(list[k + 1]), y(list[k + 1]));
        }
        pen.stroke();
      };
      lines(pairs, thin);
      if (!grows) {
        lines(part.outline, 2 * thin);
        this.above(pen, X, Y, x, y, t, cells, thin);
        pen.beginPath();
        pen.arc(X(centre[0]), Y(centre[1]), DOT + 1.2, 0, 2 * Math.PI);
        pen.fillStyle = "#fff";
        pen.fill();
        pen.beginPath();
        pen.arc(X(centre[0]), Y(centre[1]), DOT, 0, 2 * Math.PI);
        pen.fillStyle = "#000";
        pen.fill();
      }
      this.bar(pen, width, height, scale);
      this.figure.dataset.centre = `${centre[0]} ${centre[1]}`;
      this.figure.dataset.frame = `${width} ${height} ${scale} ${mx} ${my}`;
    }

    // A line every metre, so that motion is seen; every fifth one is darker.
    grid(pen, width, height, scale, mx, my, X, Y) {
      const every = scale < 14 ? 5 : 1;
      for (const [size, middle, place, across] of [[width, mx, X, false], [height, my, Y, true]]) {
        const first = Math.ceil((middle - size / 2 / scale) / every) * every;
        for (let metre = first; metre <= middle + size / 2 / scale; metre += every) {
          pen.fillStyle = metre % 5 ? "#f3f4f6" : "#e4e7ec";
          across ? pen.fillRect(0, place(metre), width, 1) : pen.fillRect(place(metre), 0, 1, height);
        }
      }
    }

    world(pen, width, height, scale, X, Y, t) {
      this.life.surfaces.forEach((line, ceiling) => {
        const edge = ceiling ? -5 : height + 5;
        pen.beginPath();
        pen.moveTo(X(line[0][0]), edge);
        line.forEach(([x, y]) => pen.lineTo(X(x), Y(y)));
        pen.lineTo(X(line[line.length - 1][0]), edge);
        pen.fillStyle = "#e8e6e1";
        pen.fill();
        pen.beginPath();
        line.forEach(([x, y], k) => k ? pen.lineTo(X(x), Y(y)) : pen.moveTo(X(x), Y(y)));
        pen.strokeStyle = QUIET;
        pen.lineWidth = 1.5;
        pen.stroke();
        pen.lineWidth = 1;
        for (let metre = Math.ceil(line[0][0]), k = 1; metre <= line[line.length - 1][0]; metre++) {
          while (k < line.length - 1 && line[k][0] < metre) k++;
          const [[ax, ay], [bx, by]] = [line[k - 1], line[k]], y = bx > ax ? ay + (by - ay) * (metre - ax) / (bx - ax) : by;
          pen.fillStyle = QUIET;
          pen.fillRect(X(metre) - 0.5, ceiling ? Y(y) - (metre % 5 ? 5 : 10) : Y(y), 1, metre % 5 ? 5 : 10);
          if (metre % 5 === 0 && !ceiling && X(metre) > 0 && X(metre) < width) this.text(pen, `${metre}`, X(metre), Y(y) + 22, "center");
        }
      });
      const [, tx, ty] = this.target(t);
      if (tx === null) return;
      pen.strokeStyle = "rgba(132,92,196,0.35)";
      pen.lineWidth = 1;
      for (let ring = 1; this.life.reach && ring <= this.film.rings; ring++) {
        pen.beginPath();
        pen.arc(X(tx), Y(ty), ring / this.film.rings * this.life.reach * scale, 0, 2 * Math.PI);
        pen.stroke();
      }
    }

    target(t) { return this.life.target.reduce((held, change) => change[0] <= t ? change : held, [0, null, null]); }

    star(pen, x, y) {
      pen.beginPath();
      for (let k = 0; k < 10; k++) {
        const size = k % 2 ? 5 : 12, angle = Math.PI * (k / 5 - 0.5);
        pen.lineTo(x + size * Math.cos(angle), y + size * Math.sin(angle));
      }
      pen.closePath();
      pen.fillStyle = TARGET;
      pen.fill();
      pen.strokeStyle = "#fff";
      pen.lineWidth = 1.5;
      pen.stroke();
    }

    // The target, the way of the centre of mass, and cells that touch.
    above(pen, X, Y, x, y, t, cells, thin) {
      const [, tx, ty] = this.target(t);
      if (tx !== null) this.star(pen, X(tx), Y(ty));
      const every = Math.max(1, Math.floor(t / 500));
      pen.beginPath();
      for (let k = 0; k <= t; k += every) pen.lineTo(X(this.centre[2 * k]), Y(this.centre[2 * k + 1]));
      pen.lineTo(X(this.centre[2 * t]), Y(this.centre[2 * t + 1]));
      pen.strokeStyle = PATH;
      pen.lineWidth = 2;
      pen.stroke();
      if (!this.touch) return;
      for (let k = 0; k < cells; k++) {
        const bit = t * cells + k;
        if (!(this.touch[bit >> 3] >> (7 - bit % 8) & 1)) continue;
        pen.beginPath();
        pen.moveTo(x(k), y(k) - 6);
        pen.lineTo(x(k) - 6, y(k) + 5);
        pen.lineTo(x(k) + 6, y(k) + 5);
        pen.closePath();
        pen.fillStyle = PATH;
        pen.fill();
        pen.strokeStyle = "#fff";
        pen.lineWidth = Math.max(1, thin);
        pen.stroke();
      }
    }

    bar(pen, width, height, scale) {
      const wanted = width / 4 / scale, power = 10 ** Math.floor(Math.log10(wanted));
      const metres = [5, 2, 1].map((one) => one * power).find((one) => one <= wanted) || power, length = metres * scale;
      pen.fillStyle = "rgba(255,255,255,0.85)";
      pen.fillRect(width - length - 22, 8, length + 14, 32);
      pen.fillStyle = INK;
      pen.fillRect(width - length - 15, 30, length, 3);
      this.text(pen, `${metres} m`, width - 15 - length / 2, 23, "center");
      const words = this.words();
      pen.font = "14px system-ui, sans-serif";
      pen.fillStyle = "rgba(255,255,255,0.85)";
      pen.fillRect(8, 8, pen.measureText(words).width + 14, 26);
      this.text(pen, words, 15, 26, "left");
    }

    text(pen, words, x, y, align) {
      pen.font = "14px system-ui, sans-serif";
      pen.fillStyle = INK;
      pen.textAlign = align;
      pen.fillText(words, x, y);
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
