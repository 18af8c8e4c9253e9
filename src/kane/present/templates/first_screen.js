// SPDX-License-Identifier: BSD-3-Clause
// The first screen: plots and terms on the viewer's time, and sliders that run the kernel anew. Needs viewer.js and engine.js.
"use strict";
(() => {
const root = document.querySelector(".first");
if (!root) return;
const told = JSON.parse(root.querySelector("script.first-data").textContent);
const view = root.querySelector(".kane-view");
const SVG = "http://www.w3.org/2000/svg";
const part = (name, given, text) => {
  const e = document.createElementNS(SVG, name);
  for (const [k, v] of Object.entries(given)) e.setAttribute(k, String(v));
  if (text !== undefined) e.textContent = text;
  return e;
};
const short = (x) => (x === 0 ? "0" : Math.abs(x) >= 1e4 || Math.abs(x) < 1e-3 ? x.toExponential(2).replace(/\.?0*e\+?/, "e") : String(Number(x.toPrecision(4)))).replace("-", "−");
const steps = (low, high, most) => {
  const raw = (high - low) / most || 1, e = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((k) => k * e >= raw) * e, out = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9 * step; v += step) out.push(Math.abs(v) < 1e-9 * step ? 0 : v);
  return out;
};

class Plot {
  constructor(box, first) {
    Object.assign(this, { box, first, svg: box.querySelector("svg"), lines: box.dataset.lines.split(",").map(Number), values: [...box.querySelectorAll("output")] });
    this.svg.addEventListener("pointerdown", (e) => { this.svg.setPointerCapture(e.pointerId); this.scrub(e); });
    this.svg.addEventListener("pointermove", (e) => { if (this.svg.hasPointerCapture(e.pointerId)) this.scrub(e); });
  }
  scrub(e) {
    const { left, width } = this.svg.getBoundingClientRect(), s = this.first.viewer.sources[0], x = ((e.clientX - left) / width) * this.w;
    this.first.viewer.play(false);
    this.first.viewer.seek(s.start + ((x - 44) / (this.w - 52)) * (s.end - s.start));
  }
  draw(source, begin) {
    const h = 120, w = (this.w = Math.max(this.svg.clientWidth || 300, 220)), n = source.time.length, { svg } = this;
    svg.setAttribute("viewBox", `0 0 ${w} ${h}`); svg.replaceChildren();
    let low = Infinity, high = -Infinity;
    for (const k of this.lines) for (let i = 0; i < n; i++) { const v = source.rows[i * source.width + begin + k]; if (v < low) low = v; if (v > high) high = v; }
    if (!(high >= low)) { low = 0; high = 1; }
    const pad = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
    low -= pad; high += pad;
    const t0 = source.start, t1 = source.end, X = (this.X = (t) => 44 + ((w - 52) * (t - t0)) / (t1 - t0 || 1)), Y = (v) => 6 + ((h - 26) * (high - v)) / (high - low);
    for (const v of steps(low, high, 4)) { svg.append(part("line", { x1: 44, x2: w - 8, y1: Y(v), y2: Y(v), class: v === 0 ? "zero" : "rule" }), part("text", { x: 40, y: Y(v) + 4, "text-anchor": "end" }, short(v))); }
    for (const t of steps(t0, t1, w / 90)) svg.append(part("text", { x: X(t), y: h - 5, "text-anchor": "middle" }, short(t)));
    this.lines.forEach((k, c) => {
      let d = "", pen = "M";
      for (let i = 0; i < n; i++) { const v = source.rows[i * source.width + begin + k]; if (Number.isFinite(v)) { d += `${pen}${X(source.time[i]).toFixed(1)} ${Y(v).toFixed(1)}`; pen = "L"; } else pen = "M"; }
      svg.append(part("path", { d, class: `line c${c}` }));
    });
    this.cursor = part("line", { y1: 4, y2: h - 20, class: "now" }); svg.append(this.cursor);
  }
  at(t, row, begin) {
    this.cursor?.setAttribute("x1", this.X(t)); this.cursor?.setAttribute("x2", this.X(t));
    this.values.forEach((o, c) => { o.textContent = short(row[begin + this.lines[c]]); });
  }
}

class First {
  constructor(viewer) {
    this.viewer = viewer;
    const [P, R, D, S] = viewer.data.counts;
    this.begin = 3 * P + 9 * R + 3 * D + S;
    this.plots = [...root.querySelectorAll(".plot")].map((box) => new Plot(box, this));
    this.terms = [...root.querySelectorAll(".row")].map((row) => [...row.querySelectorAll(".term")].map((e) => ({ k: Number(e.dataset.k), bar: e.querySelector(".bar"), value: e.querySelector("output") })));
    view.addEventListener("kane-time", (e) => this.show(e.detail));
    new ResizeObserver(() => this.draw()).observe(root);
    this.draw();
    if (told.live) this.live().catch((e) => this.say(String(e.message || e)));
  }
  say(text) { const p = root.querySelector(".status"); if (p) p.textContent = text; }
  draw() {
    const s = this.viewer.sources[0];
    this.plots.forEach((p) => p.draw(s, this.begin));
    this.largest = this.terms.map((row) => Math.max(1e-300, ...row.map(({ k }) => { let m = 0; for (let i = 0; i < s.time.length; i++) { const v = Math.abs(s.rows[i * s.width + this.begin + k]); if (v > m) m = v; } return m; })));
    this.show(this.viewer.t);
  }
  show(t) {
    const row = this.viewer.sources[0].at(t);
    this.plots.forEach((p) => p.at(t, row, this.begin));
    this.terms.forEach((terms, r) => terms.forEach(({ k, bar, value }) => {
      const v = row[this.begin + k], share = Math.max(-1, Math.min(1, v / this.largest[r]));
      bar.style.left = `${50 + Math.min(0, share) * 50}%`; bar.style.width = `${Math.abs(share) * 50}%`; value.textContent = short(v);
    }));
  }
  async live() {
    const { live } = told;
    const [run, bytes] = await Promise.all([live.run, live.read].map((text) => window.KaneViewer.numbers(text, Uint8Array)));
    this.engine = await KaneEngine.from(run);
    const module = await WebAssembly.compile(bytes);
    this.reader = (await WebAssembly.instantiate(module, { Math })).exports;
    const places = JSON.parse(new TextDecoder().decode(WebAssembly.Module.customSections(module, "kane")[0]));
    this.readers = places.programs || [places];
    this.numbers = new Float64Array(this.reader.memory.buffer);
    this.state = { ...live.state }; this.parameters = { ...live.parameters };
    root.querySelectorAll(".slider input").forEach((input) => {
      const to = input.dataset.kind === "state" ? this.state : this.parameters, said = input.parentElement.querySelector("output");
      input.addEventListener("input", () => { to[input.dataset.name] = Number(input.value); said.textContent = short(Number(input.value)); this.rerun(); });
    });
    root.querySelector(".reset")?.addEventListener("click", () => {
      this.state = { ...live.state }; this.parameters = { ...live.parameters };
      root.querySelectorAll(".slider input").forEach((i) => { i.value = i.dataset.value; i.parentElement.querySelector("output").textContent = short(Number(i.dataset.value)); });
      this.rerun();
    });
    root.classList.add("runs");
    root.first = this;
  }
  rerun() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.run(); });
  }
  /** The motion anew: the engine's, read at its samples. */
  run() {
    const before = performance.now(), { live } = told, { parameters, state } = this, [rtol, atol] = live.tolerances;
    let motion;
    try { motion = this.engine.simulate({ state, parameters, inputs: live.inputs, end: told.end, samples: told.samples, rtol, atol, maxSeconds: 2 }); }
    catch (e) { this.say(e.message); return; }
    if (motion.modes && !motion.modes.length) { this.say(root.querySelector(".status").dataset.begins); return; }
    const put = (at, values) => this.numbers.set(values, at / 8), modes = motion.modes || [{ t: 0, mode: 0, numbers: {} }];
    const count = motion.times.length, rows = new Float64Array(count * live.count);
    let which = -1, read;
    for (let i = 0; i < count; i++) {
      for (; which < modes.length - 1 && (which < 0 || modes[which + 1].t <= motion.times[i]); read = null) which++;
      const { mode, numbers } = modes[which], { ports, h, out, symbols, prefix = "" } = this.readers[mode];
      if (!read) {
        put(ports.p, symbols.p.map(([name]) => numbers[name] ?? parameters[name] ?? 0)); put(ports.r, (symbols.r || []).map(([name]) => live.inputs[name] ?? 0));
        this.reader[`${prefix}hoist`](ports.p, h);
        read = this.reader[`${prefix}outputs`];
      }
      put(ports.x, motion.states.subarray(i * motion.n, i * motion.n + symbols.x.length));
      read(...Object.keys(symbols).map((name) => (name === "t" ? motion.times[i] : ports[name])), h, out.outputs);
      rows.set(this.numbers.subarray(out.outputs / 8, out.outputs / 8 + live.count), i * live.count);
    }
    const { Sampled } = window.KaneViewer, source = new Sampled(motion.times, rows, live.count);
    this.motion = motion; this.viewer.sources[0] = source;
    this.took = performance.now() - before;
    const { anew, ends, undecided } = root.querySelector(".status").dataset, last = motion.events[motion.events.length - 1];
    const by = motion.code === "DECIDE" || motion.code === "TAKE" ? `: ${undecided}` : last ? `: ${last.name}` : "";
    this.say(motion.code === "DONE" || motion.code === "END" ? `${anew}: ${this.took.toFixed(0)} ms` : `${ends} t = ${short(motion.time)} s${by} (${this.took.toFixed(0)} ms)`);
    if (motion.modes) this.strips(motion);
    this.draw(); this.viewer.seek(Math.min(this.viewer.t, source.end));
  }
  /** What each contact does over time. */
  strips({ modes, times }) {
    const { colours } = told.live, end = times[times.length - 1] || 1;
    root.querySelectorAll(".modes .strip").forEach((strip, c) => {
      const stops = modes.map(({ t, words }, k) => `${colours[words[c]]} ${((100 * t) / end).toFixed(3)}% ${((100 * (k + 1 < modes.length ? modes[k + 1].t : end)) / end).toFixed(3)}%`);
      strip.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    });
  }
}
const start = () => { if (view.viewer) new First(view.viewer); };
if (view.viewer) start(); else view.addEventListener("kane-ready", start, { once: true });
})();
