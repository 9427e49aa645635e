/* Light or dark: as the system says, or as chosen; "#dark" and "#light" in the address choose, too. */
"use strict";
const Theme = {
  listeners: [],
  system: window.matchMedia("(prefers-color-scheme: dark)"),
  stored() {
    const asked = location.hash.slice(1).split(";").find((part) => part === "dark" || part === "light");
    if (asked) return asked;
    try { return localStorage.getItem("theme"); } catch { return null; }
  },
  get current() { return document.documentElement.dataset.theme; },
  colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); },
  apply(theme) {
    if (theme === this.current) return;
    document.documentElement.dataset.theme = theme;
    const button = document.getElementById("theme");
    if (button) button.textContent = theme === "dark" ? "Light" : "Dark";
    for (const listener of this.listeners) listener();
  },
  follow() { this.apply(this.stored() || (this.system.matches ? "dark" : "light")); },
  toggle() {
    const theme = this.current === "dark" ? "light" : "dark";
    try { localStorage.setItem("theme", theme); } catch { /* a page from disk may have no storage */ }
    this.apply(theme);
  },
};
Theme.follow();
Theme.system.addEventListener("change", () => Theme.follow());
document.addEventListener("DOMContentLoaded", () => {
  const button = document.getElementById("theme");
  button.textContent = Theme.current === "dark" ? "Light" : "Dark";
  button.addEventListener("click", () => Theme.toggle());
});
let beforePrint = null;
window.addEventListener("beforeprint", () => { beforePrint = Theme.current; Theme.apply("light"); });
window.addEventListener("afterprint", () => { if (beforePrint) Theme.apply(beforePrint); });
