"use strict";

// A symbol that is pointed at, or whose slider has the focus, is marked wherever it stands in the sketch, on the first screen and
// in the section pointed at. In a formula it is known by the text of its letters and indices, which KaTeX is asked for.
{
  const MOST = 20000; // elements of formulas that are searched without a pause
  const names = new Map(), keys = new Map();
  const letters = (place) => place.textContent.replace(/[\u200b\s]/g, "");
  const asked = document.createElement("span");
  for (const [name, latex] of JSON.parse(document.querySelector("main").dataset.symbols)) {
    katex.render(latex, asked, { output: "html", throwOnError: false });
    const key = letters(asked);
    names.set(key, name);
    keys.set(name, key);
  }

  function namesAt(place) {
    const label = place.closest("text[data-s]");
    if (label) return label.dataset.s.split(" ");
    const slider = place.closest("label.slider");
    let found = slider && [...slider.querySelectorAll(".mord")].map(letters).find((key) => names.has(key));
    for (let part = place.closest(".mord"); part; part = part.parentElement.closest(".mord")) {
      if (names.has(letters(part))) found = letters(part); // the largest: q of q_1 is none
    }
    return found ? [names.get(found)] : [];
  }

  let marked = [];
  function mark(place) {
    const wanted = place ? namesAt(place) : [];
    for (const part of marked) part.classList.remove("same");
    marked = [];
    if (!wanted.length) return;
    const sections = new Set([document.querySelector("section"), place.closest("section")]);
    for (const name of wanted) {
      marked.push(...document.querySelectorAll(`text[data-s~="${CSS.escape(name)}"]`));
      for (const section of sections) {
        const parts = section ? section.querySelectorAll(".katex-html .mord") : [];
        if (parts.length > MOST) continue;
        for (const part of parts) if (letters(part) === keys.get(name)) marked.push(part);
      }
    }
    for (const part of marked) part.classList.add("same");
  }

  addEventListener("pointerover", (event) => mark(event.target));
  addEventListener("pointerleave", () => mark(null));
  addEventListener("focusin", (event) => mark(event.target));
  addEventListener("focusout", () => mark(null));
}
