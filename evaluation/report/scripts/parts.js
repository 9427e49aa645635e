/* Scenarios that are in files beside the page, which is too large with them: each is loaded when somebody asks for it. */
"use strict";
const Parts = {
  starters: [],
  loading: new Map(),

  /* Run a function on the page, and on each part once it is there. */
  each(starter) {
    this.starters.push(starter);
    starter(document);
  },

  /* Promise that a section is there. */
  load(id) {
    const stub = document.getElementById(id);
    if (!stub?.dataset.part) return this.loading.get(id) || Promise.resolve();
    if (!this.loading.has(id)) this.loading.set(id, new Promise((resolve) => this.read(stub, resolve)));
    return this.loading.get(id);
  },

  read(stub, resolve) {
    const script = document.createElement("script"), said = stub.querySelector("[data-load]");
    const { id, dataset: { part } } = stub;
    said.textContent = "Loading …";
    script.onload = resolve;
    script.onerror = () => {
      this.loading.delete(id);
      said.textContent = `${part} cannot be read; keep it beside this page. Try again`;
    };
    script.src = part;
    document.head.append(script);
  },

  /* Called by the file of a section with its text. */
  receive(id, text) {
    document.getElementById(id).outerHTML = text;
    for (const starter of this.starters) starter(document.getElementById(id));
  },

  /* Go to a section that the address names. */
  async follow(id) {
    if (!document.getElementById(id)?.dataset.part) return;
    await this.load(id);
    document.getElementById(id).scrollIntoView();
  },
};
document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-load]");
  if (button) Parts.load(button.dataset.load);
});
window.addEventListener("hashchange", () => Parts.follow(location.hash.slice(1)));
Parts.follow(location.hash.slice(1));
