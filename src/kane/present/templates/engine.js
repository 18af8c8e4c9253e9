// SPDX-License-Identifier: BSD-3-Clause
// A motion in the page: the module that kane emits (`kane emit --target wasm --with-integrator METHOD`), given values, run, and read.
// const engine = await KaneEngine.from(base64);
// const motion = engine.simulate({state: {q1: 0.1, u1: 0}, parameters: {m: 2}, end: 10, samples: 601});
"use strict";

class KaneEngine {
  // From bytes, or from text in base64.
  static async from(source) {
    const bytes = typeof source === "string" ? Uint8Array.from(atob(source), (c) => c.charCodeAt(0)) : source;
    const module = await WebAssembly.compile(bytes);
    return new KaneEngine(module, await WebAssembly.instantiate(module, { Math }));
  }

  constructor(module, instance) {
    this.run = instance.exports;
    this.tells = JSON.parse(new TextDecoder().decode(WebAssembly.Module.customSections(module, "kane")[0]));
    this.numbers = new Float64Array(instance.exports.memory.buffer);
  }

  // The doubles of an array of the module's memory, which are no copy.
  array(name, length) {
    const first = this.tells.at[name] / 8;
    return this.numbers.subarray(first, first + length);
  }

  // Values by name, or in order, into an array; those that are left out have their defaults.
  fill(array, port, given, kind) {
    const symbols = this.tells.symbols[port];
    const values = Array.isArray(given) || ArrayBuffer.isView(given) ? Object.fromEntries(symbols.map(([name], k) => [name, given[k]])) : given;
    const known = this.array(array, symbols.length);
    for (const name of Object.keys(values)) {
      if (!symbols.some((symbol) => symbol[0] === name)) {
        throw new RangeError(`Expected one of ${symbols.map((s) => s[0]).join(", ")} in ${kind}, got ${name}.`);
      }
    }
    symbols.forEach(([name, , standard], k) => {
      const value = values[name] ?? standard;
      if (!Number.isFinite(value)) {
        throw new RangeError(`Expected a finite number for ${name} in ${kind}, got ${value}.`);
      }
      known[k] = value;
    });
  }

  // The motion from the state at time 0. `times` and `states`, of `n` numbers a row, of which the last is the work, are copies.
  simulate({ state, parameters = {}, inputs = {}, end, samples = 501, rtol = 1e-9, atol = 1e-9, maxStep = Infinity, maxSteps = 1e6, maxSeconds = Infinity }) {
    const { n, slots, codes, begun, events, constraints } = this.tells;
    if (!(samples >= 2 && samples <= this.tells.samples)) {
      throw new RangeError(`Expected 2 to ${this.tells.samples} samples, got ${samples}.`);
    }
    this.fill("y", "x", state, "the state");
    this.fill("p", "p", parameters, "the parameters");
    this.fill("r", "r", inputs, "the inputs");
    const s = this.array("s", Object.keys(slots).length);
    Object.entries({ END: end, RTOL: rtol, ATOL: atol, LONGEST: maxStep }).forEach(([slot, value]) => (s[slots[slot]] = value));
    const told = this.run.begin(samples);
    const which = this.array("told", 3);
    if (told === begun.WRONG) {
      throw new RangeError(`Expected end, rtol, atol and maxStep above zero, got ${end}, ${rtol}, ${atol} and ${maxStep}.`);
    }
    if (told === begun.OPEN) {
      throw new RangeError(`Expected a start on the constraints, got ${which[1]} left of ${constraints[which[0]]} and ${which[2]} of its rate.`);
    }
    if (told === begun.ON_THRESHOLD) {
      throw new RangeError(`Expected a start beside the threshold of the event ${events[which[0]]}, got one on it.`);
    }
    const motion = { n, events: [], jumps: [] };
    const until = performance.now() + 1000 * maxSeconds;
    if (this.tells.contacts) {
      return this.led(motion, s, maxSteps, until);
    }
    let back = codes.LIMIT;
    for (let goesOn = true; goesOn; ) {
      back = this.run.run(Math.min(1000, maxSteps - s[slots.STEPS]), samples - 1);
      this.collect(motion, s);
      goesOn = back === codes.FULL || (back === codes.LOOK && constraints.length > 0 && this.run.look() === 1);
      goesOn ||= back === codes.LIMIT && s[slots.STEPS] < maxSteps && performance.now() < until;
    }
    const count = s[slots.SAMPLE] + 1;
    motion.times = Float64Array.of(0, ...this.array("times", count - 1));
    motion.states = this.array("states", count * n).slice();
    motion.code = Object.keys(codes).find((name) => codes[name] === back);
    motion.time = s[slots.TIME];
    motion.steps = s[slots.STEPS];
    return motion;
  }

  // From mode to mode of contacts: `modes` of the motion say when each begins, which one it is, and what numbers it has.
  led(motion, s, maxSteps, until) {
    const { n, slots, contacts } = this.tells;
    const { back, asked } = contacts;
    motion.modes = [];
    let said = back.FULL;
    for (let enter = 2; said === back.FULL && performance.now() < until; enter = 1) {
      said = this.run.run(...asked.map((name) => ({ enter, most: maxSteps })[name]));
      this.collectModes(motion, said === back.TAKE);
    }
    const count = s[slots.SAMPLE] + 1;
    motion.times = Float64Array.of(0, ...this.array("times", count - 1));
    motion.states = this.array("states", count * n).slice();
    motion.states.set(motion.modes.length ? motion.modes[0].first : []);
    motion.code = Object.keys(back).find((name) => back[name] === said);
    motion.time = motion.modes.length ? s[slots.TIME] : 0;
    motion.steps = s[slots.STEPS];
    return motion;
  }

  // The modes that were completed, with the events that ended them, and, if asked for, the one that was broken off.
  collectModes(motion, broken) {
    const { n, contacts } = this.tells;
    const { row, width, words, events, numbers } = contacts;
    const [count, noted] = this.array("records", 2);
    const rows = this.array("records", 2 + (count + 1) * width).subarray(2);
    const met = this.array("noted", 2 * noted);
    let done = 0;
    for (let k = 0; k < count + (broken ? 1 : 0); k++) {
      const own = rows.subarray(k * width, (k + 1) * width);
      const first = own.slice(row.MORE + numbers.length, row.MORE + numbers.length + n);
      const before = motion.modes[motion.modes.length - 1];
      if (before && first.some((x, i) => x !== before.last[i])) {
        motion.jumps.push({ t: own[row.BEGIN], before: before.last, after: first });
      }
      const given = Object.fromEntries(numbers.map((name, i) => [name, own[row.MORE + i]]).filter(([name]) => name !== null));
      const mode = own[row.MODE];
      motion.modes.push({ t: own[row.BEGIN], mode, words: words[mode], numbers: given, first, last: own.slice(width - n, width) });
      for (; k < count && done < own[row.NOTED]; done++) {
        motion.events.push({ t: met[2 * done], name: events[mode][met[2 * done + 1]] });
      }
    }
  }

  // What was noted of events, and of what they changed, since this was last asked.
  collect(motion, s) {
    const { n, slots, events } = this.tells;
    if (!events.length) {
      return;
    }
    const logged = this.array("log", 2 * s[slots.LOGGED]);
    for (let k = 0; k < logged.length; k += 2) {
      motion.events.push({ t: logged[k], name: events[logged[k + 1]] });
    }
    const width = 2 * n + 2;
    const jumps = this.array("jumps", width * s[slots.JUMPS]);
    for (let k = 0; k < jumps.length; k += width) {
      motion.jumps.push({ t: jumps[k], before: jumps.slice(k + 2, k + 2 + n), after: jumps.slice(k + 2 + n, k + width) });
    }
    s[slots.LOGGED] = 0;
    s[slots.JUMPS] = 0;
  }
}
