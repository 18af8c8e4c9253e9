// SPDX-License-Identifier: BSD-3-Clause
// Shows a scene in motion on a canvas by WebGL 2: orbit, play, scrub, follow, forces, axes, paths, ghosts.
// Data: see kane.present.viewer.page. A source of poses gives a row of numbers at a time: positions, axes, directions, scalars.
"use strict";
(() => {
const GLSL = {
  vertex: `#version 300 es
in vec3 p; in vec3 n; in float tone;
uniform mat4 view; uniform mat4 place; uniform mat3 turn; uniform vec4 floor_; uniform vec3 light; uniform bool shade;
out vec3 normal; out vec3 world; out float t;
void main() {
  vec4 w = place * vec4(p, 1.0);
  if (shade) { float h = dot(floor_.xyz, w.xyz) - floor_.w; w.xyz -= light * (h / dot(light, floor_.xyz)); w.xyz += floor_.xyz * 1e-4; }
  normal = turn * n; world = w.xyz; t = tone; gl_Position = view * w;
}`,
  fragment: `#version 300 es
precision highp float;
in vec3 normal; in vec3 world; in float t;
uniform vec3 colour; uniform vec3 eye; uniform vec3 up; uniform vec3 light; uniform float alpha; uniform int kind; uniform vec4 grid; uniform vec3 centre;
out vec4 pixel;
void main() {
  if (kind == 1) { pixel = vec4(colour, alpha); return; }
  if (kind == 2) {
    vec3 a = abs(up.z) < 0.9 ? normalize(cross(up, vec3(0.0, 0.0, 1.0))) : vec3(1.0, 0.0, 0.0); vec3 b = cross(up, a);
    vec2 q = vec2(dot(world, a), dot(world, b)) / grid.x; vec2 w = fwidth(q);
    vec2 l = 1.0 - smoothstep(vec2(0.0), 1.5 * w, abs(fract(q - 0.5) - 0.5));
    float far = 1.0 - smoothstep(0.35 * grid.y, grid.y, distance(world, centre));
    pixel = vec4(colour, (0.05 + 0.22 * max(l.x, l.y)) * far); return;
  }
  vec3 n = normalize(normal); vec3 v = normalize(eye - world);
  if (dot(n, v) < 0.0) n = -n;
  float d = max(dot(n, light), 0.0), sky = 0.5 + 0.5 * dot(n, up), s = pow(max(dot(n, normalize(light + v)), 0.0), 40.0);
  vec3 base = mix(colour, mix(colour, vec3(1.0), 0.42), t);
  pixel = vec4(base * (0.46 + 0.24 * sky + 0.42 * d) + 0.14 * s, alpha);
}`};
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const times = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const s = Math.hypot(...a); return s > 0 ? times(a, 1 / s) : a; };
const product = (a, b) => {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
};
const towards = (way) => {
  const s = Math.hypot(...way), z = s > 0 ? times(way, 1 / s) : [0, 0, 1], near = Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
  const x = unit(plus(near, z, -dot(near, z)));
  return [x, cross(z, x), z];
};
async function numbers(text, kind) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new kind(await new Response(plain).arrayBuffer());
}

/** Rows of floats: of each column the changes of its bits from row to row, all lowest bytes first. */
async function rowsOf(text, count) {
  const bytes = await numbers(text, Uint8Array), n = bytes.length / 4, width = n / count, bits = new Uint32Array(n), columns = new Float32Array(bits.buffer);
  for (let k = 0, b = 0; k < n; k++) bits[k] = b = ((k % count ? b : 0) + (bytes[k] | (bytes[n + k] << 8) | (bytes[2 * n + k] << 16) | (bytes[3 * n + k] << 24))) | 0;
  return Float32Array.from(columns, (_, k) => columns[(k % width) * count + Math.floor(k / width)]);
}

/** Poses that were sampled: rows between samples are interpolated. */
class Sampled {
  constructor(time, rows, width) { Object.assign(this, { time, rows, width, row: new Float64Array(width) }); }
  get end() { return this.time[this.time.length - 1]; }
  get start() { return this.time[0]; }
  at(t) {
    const { time, rows, width, row } = this;
    let a = 0, b = time.length - 1;
    while (b - a > 1) { const m = (a + b) >> 1; if (time[m] <= t) a = m; else b = m; }
    if (b > 0 && t >= time[b]) a = b;
    const h = a < b ? Math.min(Math.max((t - time[a]) / (time[b] - time[a]), 0), 1) : 0;
    const i = a * width, j = (h > 0 ? b : a) * width;
    for (let k = 0; k < width; k++) row[k] = h > 0 ? rows[i + k] * (1 - h) + rows[j + k] * h : rows[i + k];
    return row;
  }
}

class Viewer {
  constructor(root, data, sources) {
    Object.assign(this, { root, data, sources, playing: false, t: sources[0].start, forces: false, axes: false, paths: true, follow: data.travels });
    const [P, R, D] = data.counts;
    this.from = [0, 3 * P, 3 * P + 9 * R, 3 * P + 9 * R + 3 * D];
    this.canvas = root.querySelector("canvas");
    const gl = (this.gl = this.canvas.getContext("webgl2", { antialias: true, stencil: true, alpha: true, premultipliedAlpha: false }));
    if (!gl) { root.classList.add("still"); return; }
    this.program = this.build();
    this.meshes = data.meshes.map((m) => this.load(m));
    this.home(); this.watch(); this.colours();
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => { this.colours(); this.draw(); });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    const span = sources[0].end - sources[0].start, whole = span / 8;
    this.speed = span > 1 && span < 40 ? 1 : 10 ** Math.floor(Math.log10(whole)) * [1, 2, 5].reverse().find((k) => k * 10 ** Math.floor(Math.log10(whole)) <= whole * 1.001);
    this.controls();
    this.seek(this.t);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches && root.dataset.autoplay !== "no") this.play(true);
  }
  build() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, GLSL.vertex], [gl.FRAGMENT_SHADER, GLSL.fragment]]) {
      const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
      gl.attachShader(program, s);
    }
    ["p", "n", "tone"].forEach((name, k) => gl.bindAttribLocation(program, k, name));
    gl.linkProgram(program); gl.useProgram(program);
    const names = "view place turn floor_ light shade colour eye up alpha kind grid centre".split(" ");
    this.u = Object.fromEntries(names.map((n) => [n, gl.getUniformLocation(program, n)]));
    return program;
  }
  load(m) {
    const gl = this.gl, vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    [[m.v, 3], [m.n, 3], [m.t, 1]].forEach(([values, size], k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(k); gl.vertexAttribPointer(k, size, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, m.i, gl.STATIC_DRAW);
    return { vao, count: m.i.length };
  }
  colours() {
    const style = getComputedStyle(this.root), read = (name) => {
      const c = style.getPropertyValue(name).trim();
      return [1, 3, 5].map((k) => parseInt(c.slice(k, k + 2), 16) / 255);
    };
    this.palette = [0, 1, 2, 3, 4, 5].map((k) => read(`--body-${k}`));
    this.ink = { ground: read("--ground"), constraint: read("--held"), load: read("--load"), shadow: read("--shadow"), force: read("--load"), path: read("--now") };
  }
  home() {
    const [azimuth, height] = this.data.camera;
    Object.assign(this, { azimuth, height, distance: 3.5 * this.data.reach, centre: this.data.middle.slice() });
  }
  /** Places of a row: [x, y, z axes scaled, shift]. */
  place(part, row) {
    const [a, b, c, d] = this.from, at = (k) => [row[a + 3 * k], row[a + 3 * k + 1], row[a + 3 * k + 2]];
    const size = ([k, factor, root]) => (k < 0 ? factor : factor * (root ? Math.sqrt(Math.max(row[d + k], 0)) : row[d + k]));
    const s = part.s.map(size), p = at(part.a);
    let axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    if (part.k === "between") { const way = sub(at(part.q), p); axes = towards(way); s[2] *= Math.hypot(...way); }
    else if (part.k === "corners") {
      const [o, e, f] = part.p.map(at), x = unit(sub(e, o)), z = unit(cross(x, sub(f, o)));
      axes = [x, cross(z, x), z];
    } else if (part.d >= 0) axes = towards([0, 1, 2].map((k) => row[c + 3 * part.d + k]));
    else if (part.x >= 0) axes = [0, 1, 2].map((j) => unit([0, 1, 2].map((k) => row[b + 9 * part.x + 3 * j + k])));
    return [...axes.map((x, k) => times(x, s[k])), p];
  }
  /** The 12 numbers of a part's place at a time, for whoever compares. */
  matrix(k, t) { return this.place(this.data.parts[k], this.sources[0].at(t)).flat(); }
  eyeOf() {
    const up = this.data.up, e = this.data.front, f = cross(up, e), c = Math.cos(this.height);
    const away = plus(plus(times(e, c * Math.cos(this.azimuth)), f, c * Math.sin(this.azimuth)), up, Math.sin(this.height));
    return plus(this.centre, away, this.distance);
  }
  view(eye, aspect) {
    const z = unit(sub(eye, this.centre)), x = unit(cross(this.data.up, z)), y = cross(z, x);
    const look = [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
    const near = 0.02 * this.distance, far = 40 * this.distance, f = 1 / Math.tan(0.26) * Math.min(1, aspect / 1.2);
    return product([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, -(far + near) / (far - near), -1, 0, 0, (-2 * far * near) / (far - near), 0], look);
  }
  draw() {
    if (!this.gl || this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => { this.pending = false; this.paint(); });
  }
  paint() {
    const { gl, u, canvas, data } = this, ratio = Math.min(devicePixelRatio || 1, 2);
    const w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const rows = this.sources.map((s) => Float64Array.from(s.at(Math.min(this.t, s.end))));
    const places = rows.map((row) => data.parts.map((part) => this.place(part, row)));
    if (this.follow) this.centre = this.middle(places[0]);
    const eye = this.eyeOf(), light = unit(plus(plus(times(data.up, 1), data.front, 0.45), cross(data.up, data.front), 0.3));
    gl.viewport(0, 0, w, h); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST); gl.enable(gl.BLEND); gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.uniformMatrix4fv(u.view, false, this.view(eye, w / h)); gl.uniform3fv(u.eye, eye); gl.uniform3fv(u.light, light); gl.uniform3fv(u.up, data.up);
    gl.uniform1i(u.shade, 0); gl.uniform1f(u.alpha, 1);
    places[0].forEach((place, k) => this.mesh(data.parts[k].m, place, this.ofPart(data.parts[k]), 0));
    if (this.forces) this.pointers(rows[0], data.arrows, this.ink.force);
    if (this.axes) this.triads(rows[0]);
    const floors = this.floors(rows[0]);
    for (const [normal, height, at] of floors) {
      gl.enable(gl.STENCIL_TEST); gl.clear(gl.STENCIL_BUFFER_BIT); gl.stencilFunc(gl.EQUAL, 0, 255); gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.uniform1i(u.shade, 1); gl.uniform4f(u.floor_, ...normal, height + 2e-4 * data.size); gl.uniform1f(u.alpha, 0.18); gl.depthMask(false);
      if (dot(light, normal) > 0.1) places[0].forEach((place, k) => this.mesh(data.parts[k].m, place, this.ink.shadow, 1));
      gl.uniform1i(u.shade, 0); gl.disable(gl.STENCIL_TEST);
      this.floor(normal, at);
    }
    gl.uniform1f(u.alpha, 0.22);
    places.slice(1).forEach((own) => own.forEach((place, k) => this.mesh(data.parts[k].m, place, this.ofPart(data.parts[k]), 0)));
    gl.uniform1f(u.alpha, 0.9);
    if (this.paths) this.trails();
    gl.depthMask(true);
  }
  ofPart(part) { return part.c === "body" ? this.palette[part.b % 6] : this.ink[part.c] || this.ink.ground; }
  middle(places) {
    const sum = places.reduce((m, p) => plus(m, p[3]), [0, 0, 0]);
    return times(sum, 1 / places.length);
  }
  mesh(m, [x, y, z, p], colour, kind) {
    const { gl, u } = this, { vao, count } = this.meshes[m];
    const a = [x, y, z].map((v) => { const s = dot(v, v); return s > 0 ? times(v, 1 / s) : v; });
    gl.uniformMatrix4fv(u.place, false, [...x, 0, ...y, 0, ...z, 0, ...p, 1]); gl.uniformMatrix3fv(u.turn, false, a.flat());
    gl.uniform3fv(u.colour, colour); gl.uniform1i(u.kind, kind); gl.bindVertexArray(vao);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }
  pointer(from, way, width, colour) {
    const [x, y, z] = towards(way);
    this.mesh(this.data.arrow, [times(x, width), times(y, width), times(z, Math.hypot(...way)), from], colour, 0);
  }
  pointers(row, arrows, colour) {
    const [a, , c] = this.from, size = this.data.size;
    for (const [, at, d, largest] of arrows) {
      const way = [0, 1, 2].map((k) => row[c + 3 * d + k] / (largest || 1)), p = [0, 1, 2].map((k) => row[a + 3 * at + k]);
      if (Math.hypot(...way) > 1e-3) this.pointer(p, times(way, 0.35 * size), 0.022 * size, colour);
    }
  }
  triads(row) {
    const [a, b] = this.from, size = 0.18 * this.data.size;
    for (const [frame, at, inertial] of this.data.triads) for (let j = 0; j < 3; j++) {
      const e = [0, 1, 2].map((k) => row[b + 9 * frame + 3 * j + k]), p = [0, 1, 2].map((k) => row[a + 3 * at + k]);
      this.pointer(p, times(e, size), 0.02 * size * 3, inertial ? this.ink.constraint : this.palette[j]);
    }
  }
  floors(row) {
    const { data } = this, [a, , c] = this.from;
    if (!data.planes.length) return [[data.up, data.low, plus(this.centre, data.up, data.low - dot(this.centre, data.up))]];
    return data.planes.map(([at, d]) => {
      const n = unit([0, 1, 2].map((k) => row[c + 3 * d + k])), p = [0, 1, 2].map((k) => row[a + 3 * at + k]);
      return [n, dot(n, p), plus(this.centre, n, dot(n, p) - dot(n, this.centre))];
    });
  }
  floor(normal, at) {
    const { gl, u, data } = this, far = 4.5 * data.reach;
    if (this.square === undefined) this.square = this.meshes.push(this.load({ v: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), n: new Float32Array([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1]), t: new Float32Array(4), i: new Uint32Array([0, 1, 2, 0, 2, 3]) })) - 1;
    const [x, y, z] = towards(normal), raw = 0.45 * data.reach, e = 10 ** Math.floor(Math.log10(raw)), step = e * [5, 2, 1].find((k) => k * e <= raw * 1.0001);
    gl.uniform1f(u.alpha, 1); gl.uniform4f(u.grid, step, far, 0, 0); gl.uniform3fv(u.centre, at); gl.uniform3fv(u.up, normal);
    this.mesh(this.square, [times(x, far), times(y, far), z, at], this.ink.ground, 2);
    gl.uniform3fv(u.up, data.up);
  }
  trails() {
    const { data } = this, [a] = this.from;
    for (const p of data.traces) {
      let last = null;
      const source = this.sources[0], count = 400, begin = source.start;
      for (let k = 0; k <= count; k++) {
        const row = source.at(begin + ((this.t - begin) * k) / count), here = [0, 1, 2].map((j) => row[a + 3 * p + j]);
        if (last && Math.hypot(...sub(here, last)) > 1e-5 * data.size) { const [x, y, z] = towards(sub(here, last)), r = 0.006 * data.size; this.mesh(data.tube, [times(x, r), times(y, r), times(z, Math.hypot(...sub(here, last))), last], this.ink.path, 1); }
        last = here;
      }
    }
  }
  seek(t) {
    const [a, b] = [this.sources[0].start, this.sources[0].end];
    this.t = Math.min(Math.max(t, a), b);
    if (this.slider) { this.slider.value = String((this.t - a) / (b - a || 1)); this.slider.setAttribute("aria-valuetext", `t = ${this.t.toPrecision(4)} s`); }
    if (this.clock) this.clock.textContent = `t = ${this.t.toFixed(this.digits)} s`;
    this.root.dispatchEvent(new CustomEvent("kane-time", { detail: this.t, bubbles: true }));
    this.draw();
  }
  play(on) {
    this.playing = on; this.begun = undefined;
    if (this.button) { this.button.textContent = on ? "❚❚" : "▶"; this.button.setAttribute("aria-label", on ? this.button.dataset.pause : this.button.dataset.play); }
    if (on && this.t >= this.sources[0].end) this.seek(this.sources[0].start);
    const step = (now) => {
      if (!this.playing) return;
      const dt = this.begun === undefined ? 0 : (now - this.begun) / 1000;
      this.begun = now;
      if (this.t >= this.sources[0].end) { this.play(false); return; }
      this.seek(this.t + dt * this.speed); requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  }
  controls() {
    const find = (name) => this.root.querySelector(`[data-k="${name}"]`), span = this.sources[0].end - this.sources[0].start;
    this.digits = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10(span || 1))));
    this.button = find("play"); this.slider = find("time"); this.clock = find("clock");
    this.button?.addEventListener("click", () => this.play(!this.playing));
    this.slider?.addEventListener("input", () => { this.play(false); this.seek(this.sources[0].start + Number(this.slider.value) * span); });
    const speed = find("speed");
    if (speed) {
      const list = [0.1, 0.25, 0.5, 1, 2, 4].map((k) => k * this.speed);
      speed.replaceChildren(...list.map((k) => new Option(`× ${Number(k.toPrecision(3))}`, String(k), false, k === this.speed)));
      speed.addEventListener("change", () => { this.speed = Number(speed.value); });
    }
    for (const name of ["forces", "axes", "paths", "follow"]) {
      const box = find(name);
      if (!box) continue;
      box.checked = this[name];
      box.addEventListener("change", () => { this[name] = box.checked; if (name === "follow" && !box.checked) this.centre = this.data.middle.slice(); this.draw(); });
    }
    find("home")?.addEventListener("click", () => { this.home(); this.draw(); });
  }
  watch() {
    const c = this.canvas, held = new Map();
    let pinch = 0;
    const turn = (dx, dy) => { this.azimuth -= dx; this.height = Math.min(Math.max(this.height + dy, -1.5), 1.5); this.draw(); };
    const zoom = (k) => { this.distance = Math.min(Math.max(this.distance * k, 0.2 * this.data.size), 40 * this.data.size); this.draw(); };
    c.addEventListener("pointerdown", (e) => { c.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); c.focus({ preventScroll: true }); });
    c.addEventListener("pointermove", (e) => {
      const before = held.get(e.pointerId);
      if (!before) return;
      held.set(e.pointerId, [e.clientX, e.clientY]);
      if (held.size === 2) {
        const [p, q] = [...held.values()], d = Math.hypot(p[0] - q[0], p[1] - q[1]);
        if (pinch) zoom(pinch / d);
        pinch = d;
      } else if (e.shiftKey) {
        const z = unit(sub(this.eyeOf(), this.centre)), x = unit(cross(this.data.up, z)), y = cross(z, x), k = (0.54 * this.distance) / c.clientHeight;
        this.centre = plus(plus(this.centre, x, -(e.clientX - before[0]) * k), y, (e.clientY - before[1]) * k); this.draw();
      } else turn((e.clientX - before[0]) * 0.008, (e.clientY - before[1]) * 0.008);
    });
    const let_ = (e) => { held.delete(e.pointerId); pinch = 0; };
    c.addEventListener("pointerup", let_); c.addEventListener("pointercancel", let_);
    c.addEventListener("wheel", (e) => { if (document.activeElement === c) { e.preventDefault(); zoom(Math.exp(0.0012 * e.deltaY)); } }, { passive: false });
    const step = (k) => { this.play(false); this.seek(this.t + (k * (this.sources[0].end - this.sources[0].start)) / 200); };
    const keys = { ArrowLeft: () => turn(0.1, 0), ArrowRight: () => turn(-0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1), "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1.1), " ": () => this.play(!this.playing), ",": () => step(-1), ".": () => step(1), Home: () => { this.home(); this.draw(); } };
    c.addEventListener("keydown", (e) => { if (keys[e.key]) { e.preventDefault(); keys[e.key](); } });
  }
}

async function begin(root) {
  const data = JSON.parse(root.querySelector('script[type="application/json"]').textContent);
  const width = 3 * data.counts[0] + 9 * data.counts[1] + 3 * data.counts[2] + data.counts[3] + (data.extra || 0);
  data.meshes = await Promise.all(data.meshes.map(async (m) => ({ v: await numbers(m.v, Float32Array), n: await numbers(m.n, Float32Array), t: await numbers(m.t, Float32Array), i: await numbers(m.i, Uint32Array) })));
  const sources = await Promise.all(data.runs.map(async (r) => { const t = await numbers(r.t, Float64Array); return new Sampled(t, await rowsOf(r.rows, t.length), width); }));
  root.viewer = new Viewer(root, data, sources);
  root.dispatchEvent(new CustomEvent("kane-ready"));
}
window.KaneViewer = { Viewer, Sampled, begin, numbers };
document.querySelectorAll(".kane-view").forEach((root) => begin(root).catch((e) => { root.classList.add("still"); console.error(e); }));
})();
