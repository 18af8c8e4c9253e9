// SPDX-License-Identifier: BSD-3-Clause
// What the page carries stands before this script, deflated and in base64: [style, script, …], whose scripts the page's policy knows by
// their hashes. It is inflated while the page is read, and begins after; meanwhile what will be typeset keeps its place, unseen.
"use strict";
(async (carried) => {
  const root = document.documentElement;
  const whole = new Promise((done) => document.addEventListener("DOMContentLoaded", done, { once: true }));
  root.classList.add("loading");
  try {
    const bytes = Uint8Array.from(atob(carried), (c) => c.charCodeAt(0));
    const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const [style, ...scripts] = await new Response(plain).json();
    const begin = (kind, text) => Object.assign(document.createElement(kind), { textContent: text });
    document.head.prepend(begin("style", style)); // the page's own styles have the last word
    await whole;
    for (const text of scripts) document.body.append(begin("script", text));
  } catch (error) {
    await whole;
    const said = document.createElement("p");
    said.textContent = `${root.dataset.old} (${error.message})`;
    document.body.prepend(said);
  }
  root.classList.remove("loading");
})(document.currentScript.previousElementSibling.textContent);
