(() => {
  "use strict";
  /* Tables: a click on a head sorts, a second one the other way. */
  const compare = (a, b) => (Number.isNaN(parseFloat(a) - parseFloat(b)) ? a.localeCompare(b) : parseFloat(a) - parseFloat(b));
  for (const button of document.querySelectorAll("th button")) {
    button.addEventListener("click", () => {
      const head = button.closest("th");
      const body = head.closest("table").tBodies[0];
      const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
      const text = (row) => row.cells[head.cellIndex].textContent;
      body.append(...[...body.rows].sort((a, b) => sign * compare(text(a), text(b))));
    });
  }
})();
