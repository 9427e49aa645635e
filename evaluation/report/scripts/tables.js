/* Tables: a click on a heading sorts the rows, and what is scrolled sideways says so. */
"use strict";
class SortedTable {
  constructor(table) {
    this.body = table.tBodies[0];
    this.heads = [...table.tHead.rows[0].cells];
    for (const [place, head] of this.heads.entries()) if (this.sorts(place)) this.offer(head, place);
  }

  sorts(place) { return new Set([...this.body.rows].map((row) => this.key(row, place))).size > 1; }

  /* What a row is sorted by: the cell's figure, the number that its text begins with, or its text. */
  key(row, place) {
    const cell = row.cells[place];
    if (!cell) return "";
    const told = cell.dataset.sort ?? cell.querySelector("data")?.value ?? cell.innerText.trim().replace("\u2212", "-");
    const number = parseFloat(told);
    return Number.isNaN(number) ? told : number;
  }

  offer(head, place) {
    head.tabIndex = 0;
    head.setAttribute("aria-sort", "none");
    head.addEventListener("click", (event) => { if (!event.target.closest("a[href]:not(.term)")) this.sort(place, event); });
    head.addEventListener("keydown", (event) => { if (event.key === "Enter" && event.target === head) this.sort(place, event); });
  }

  /* Rising first; falling when it is rising already. Cells without a figure come last. */
  sort(place, event) {
    event.preventDefault();
    const rising = this.heads[place].getAttribute("aria-sort") !== "ascending";
    for (const head of this.heads) if (head.hasAttribute("aria-sort")) head.setAttribute("aria-sort", "none");
    this.heads[place].setAttribute("aria-sort", rising ? "ascending" : "descending");
    const rows = [...this.body.rows].map((row) => [this.key(row, place), row]);
    rows.sort(([one], [other]) => this.order(one, other, rising));
    this.body.append(...rows.map(([, row]) => row));
  }

  order(one, other, rising) {
    if (typeof one !== typeof other) return typeof one === "number" ? -1 : 1;
    const apart = typeof one === "number" ? one - other : one.localeCompare(other);
    return rising ? apart : -apart;
  }
}

/* The right edge fades, and a line says so, while there is more to the right. */
class Sideways {
  constructor(box) {
    this.box = box;
    this.cue = document.createElement("p");
    this.cue.className = "cue";
    this.cue.textContent = "scroll sideways for more columns →";
    box.after(this.cue);
    box.addEventListener("scroll", () => this.look(), { passive: true });
    new ResizeObserver(() => this.look()).observe(box);
    this.look();
  }

  look() {
    const { scrollWidth, clientWidth, scrollLeft } = this.box, wide = scrollWidth > clientWidth + 1;
    this.box.classList.toggle("cut", wide && scrollLeft + clientWidth < scrollWidth - 1);
    this.cue.hidden = !wide;
    if (wide) this.box.tabIndex = 0; else this.box.removeAttribute("tabindex");
  }
}

/* A link to what is folded away opens it. */
function unfold() {
  const target = document.getElementById(location.hash.slice(1));
  for (let part = target?.closest("details"); part; part = part.parentElement.closest("details")) part.open = true;
}

document.addEventListener("DOMContentLoaded", () => {
  Parts.each((part) => {
    for (const table of part.querySelectorAll("table.sortable")) new SortedTable(table);
    for (const box of part.querySelectorAll(".scroll")) new Sideways(box);
  });
  unfold();
});
window.addEventListener("hashchange", unfold);
