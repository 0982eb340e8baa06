"use strict";
// Draws one moment of a film into its canvas; player.js makes the film and says which moment.
const Picture = (() => {
  const INK = "rgb(38,43,54)", QUIET = "rgb(138,145,158)", PATH = "rgb(222,116,24)", TARGET = "rgb(132,92,196)";
  const SHADES = 200, DOT = 3.5;

  return class Picture {
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
  };
})();
