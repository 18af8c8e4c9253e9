"use strict";

// Formulas. Their LaTeX is the text of .math; a definition "Z_{1} = …" stands in a .formula with data-z="Z_{1}", and holds
// within the nearest .group. A Z in a formula of that group is a button that shows its definition below the formula.
const sources = new Map();
const definitions = new Map();
for (const place of document.querySelectorAll(".math")) sources.set(place, place.textContent);
for (const line of document.querySelectorAll("[data-z]")) {
  const group = line.closest(".group");
  if (!definitions.has(group)) definitions.set(group, new Map());
  definitions.get(group).set(line.dataset.z, sources.get(line.querySelector(".math")));
}
const Z = /(?<![A-Za-z\\])Z_\{(\d+)\}/g;

function marked(place, source) {
  const known = place.closest(".formula, td") && definitions.get(place.closest(".group"));
  if (!known) return source;
  const own = place.parentElement.dataset.z || place.parentElement.dataset.own;
  return source.replace(Z, (z, n) => (z !== own && known.has(z) ? `\\htmlData{of=${n}}{${z}}` : z));
}

function typeset(place, source) {
  const display = place.classList.contains("display");
  const lead = place.parentElement.classList.contains("formula") && !display ? "\\displaystyle " : "";
  katex.render(lead + marked(place, source), place, {
    displayMode: display, fleqn: true, throwOnError: false, strict: "ignore", trust: (c) => c.command === "\\htmlData",
  });
  if (place.closest("th")) { // the only text of its cell: named, as tables need it
    place.setAttribute("role", "math");
    place.setAttribute("aria-label", spoken(source));
  }
  const shown = place.querySelectorAll("[data-of]");
  if (!shown.length) return;
  // KaTeX hides its visual half from screen readers, who read its MathML; of that half only the buttons are shown to them.
  place.querySelector(".katex-html").removeAttribute("aria-hidden");
  const first = new Set();
  for (const z of shown) {
    if (first.has(z.dataset.of)) continue;
    first.add(z.dataset.of);
    z.tabIndex = 0;
    z.setAttribute("role", "button");
    z.setAttribute("aria-expanded", "false");
    z.setAttribute("aria-label", `${document.documentElement.dataset.definition} Z${z.dataset.of}`);
  }
  hideRest(place.querySelector(".katex-html"));
}

function spoken(source) {
  return source.replace(/\\(?:boldsymbol|mathbf|mathrm|text)\b/g, "").replace(/[\\{}]/g, "").trim();
}

function hideRest(node) {
  for (const child of node.children) {
    if (child.getAttribute("role") === "button") continue;
    if (child.querySelector("[role=button]")) hideRest(child);
    else child.setAttribute("aria-hidden", "true");
  }
}

// The first screen is typeset at once, the rest when it comes near or opens, and all of it when the page is idle or printed.
const waiting = new Map();
const upper = document.querySelector("section");
const near = new IntersectionObserver((found) => {
  const come = new Set(found.filter((f) => f.isIntersecting).map((f) => f.target));
  if (come.size) typesetWaiting((place) => come.has(place));
}, { rootMargin: "100% 0%" });
for (const [place, source] of sources) {
  if (upper.contains(place) && !place.closest("details:not([open]) > :not(summary)")) {
    typeset(place, source);
  } else {
    waiting.set(place, source);
    near.observe(place);
  }
}
function typesetWaiting(holds = () => true) {
  for (const [place, source] of waiting) {
    if (!holds(place)) continue;
    waiting.delete(place);
    near.unobserve(place);
    typeset(place, source);
  }
}
addEventListener("toggle", (event) => typesetWaiting((place) => event.target.contains(place)), true);
const later = window.requestIdleCallback || ((run) => setTimeout(() => run({ timeRemaining: () => 10 }), 50));
function idle(deadline) {
  typesetWaiting(() => deadline.timeRemaining() > 2);
  if (waiting.size) later(idle);
}
later(idle);
for (const font of document.fonts) font.load(); // printing opens what is folded and does not wait for its fonts

// What scrolls sideways can be reached by keyboard, unless something within it can.
const fits = new ResizeObserver((boxes) => {
  for (const target of new Set(boxes.map((box) => box.target.closest(".formula, .scroll")))) {
    const scrolls = target.scrollWidth > target.clientWidth && !target.querySelector("[tabindex]");
    if (scrolls) target.tabIndex = 0;
    else target.removeAttribute("tabindex");
  }
});
for (const box of document.querySelectorAll(".formula, .scroll, .scroll > table")) fits.observe(box);  // what is within grows by itself

// Definitions on demand

let count = 0;
function toggle(z) {
  const host = z.closest(".formula, .scroll");
  const n = z.dataset.of;
  let box = host.nextElementSibling;
  if (!box || !box.classList.contains("meanings")) {
    box = document.createElement("div");
    box.className = "meanings";
    host.after(box);
  }
  const old = [...box.children].find((m) => m.dataset.meaning === n);
  const open = !old;
  if (old) old.remove();
  else box.append(meaning(n, z));
  if (!box.children.length) box.remove();
  for (const same of host.querySelectorAll(`[data-of="${n}"]`)) {
    same.classList.toggle("open", open);
    if (!same.hasAttribute("aria-expanded")) continue;
    same.setAttribute("aria-expanded", String(open));
    if (open) same.setAttribute("aria-controls", box.lastElementChild.id);
    else same.removeAttribute("aria-controls");
  }
}

function meaning(n, z) {
  const source = definitions.get(z.closest(".group")).get(`Z_{${n}}`);
  const found = document.createElement("div");
  found.className = "meaning";
  found.id = `meaning-${++count}`;
  found.dataset.meaning = n;
  found.innerHTML = '<div class="formula"><span class="math"></span></div>';
  found.firstChild.dataset.own = `Z_{${n}}`;
  queueMicrotask(() => typeset(found.querySelector(".math"), source)); // once it stands in its group
  return found;
}

addEventListener("click", (event) => {
  const z = event.target.closest("[data-of]");
  if (z) toggle(z);
});
addEventListener("keydown", (event) => {
  const z = event.target.closest && event.target.closest("[data-of]");
  if (!z || (event.key !== "Enter" && event.key !== " ")) return;
  event.preventDefault();
  toggle(z);
});

// Copying

async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
}

for (const button of document.querySelectorAll("button.copy")) {
  const group = button.closest(".group");
  const name = button.textContent;
  button.hidden = false;
  button.addEventListener("click", async () => {
    const lines = [...sources].filter(([m]) => m.parentElement.matches(".formula") && m.closest(".group") === group);
    const text = lines.map(([, source]) => "  " + source.replace(" = ", " &= ")).join(" \\\\\n");
    await copied(`\\begin{align*}\n${text}\n\\end{align*}\n`);
    button.textContent = button.dataset.done;
    setTimeout(() => (button.textContent = name), 2000);
  });
}

// Printing: what is folded opens unless it is very long, and what is wider than the paper shrinks.

const LINES = 80;
let opened = [];
addEventListener("beforeprint", () => {
  typesetWaiting();
  opened = [...document.querySelectorAll("details:not([open])")].filter((d) => !(d.dataset.lines > LINES));
  for (const d of opened) d.open = true;
  document.documentElement.classList.add("printing");
  const boxes = [...document.querySelectorAll(".formula, .scroll")];
  const sizes = boxes.map((box) => (0.99 * box.clientWidth) / box.scrollWidth); // all are measured before any is changed
  boxes.forEach((box, i) => { if (sizes[i] < 0.99) box.style.zoom = sizes[i]; });
});
addEventListener("afterprint", () => {
  for (const d of opened) d.open = false;
  for (const box of document.querySelectorAll(".formula, .scroll")) box.style.zoom = "";
  document.documentElement.classList.remove("printing");
});
