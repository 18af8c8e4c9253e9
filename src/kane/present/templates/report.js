for (const place of document.querySelectorAll(".math")) {
  const display = place.classList.contains("display");
  const source = place.textContent;
  const long = place.parentElement.classList.contains("formula");
  katex.render(long && !display ? "\\displaystyle " + source : source, place, { displayMode: display, fleqn: true, throwOnError: false });
}
const folded = () => [...document.querySelectorAll("details:not([open])")];
let opened = [];
addEventListener("beforeprint", () => { opened = folded(); for (const d of opened) d.open = true; });
addEventListener("afterprint", () => { for (const d of opened) d.open = false; });
