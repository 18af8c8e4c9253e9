// SPDX-License-Identifier: BSD-3-Clause
// Each element of class `tex` holds LaTeX; KaTeX sets it. Where that fails the LaTeX stays, in red.
for (const place of document.querySelectorAll(".tex")) {
  katex.render(place.textContent, place, { displayMode: place.tagName === "DIV", throwOnError: false });
}
