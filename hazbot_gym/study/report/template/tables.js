"use strict";
// Unpacks the long tables, sorts a table by a column when its title is clicked, saves tables as CSV.
(async () => {
  if (!("DecompressionStream" in window)) return;
  const all = document.getElementById("tables");
  all.insertAdjacentHTML("beforeend", await inflate("table-data"));

  const value = (row, column) => row.cells[column].firstChild?.textContent.trim() ?? "";

  function sort(table, column, title) {
    const isDown = title.getAttribute("aria-sort") !== "descending";
    for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    title.setAttribute("aria-sort", isDown ? "descending" : "ascending");
    const body = table.tBodies[0];
    const rows = [...body.rows].map((row) => [row, parseFloat(value(row, column)), row.cells[column].textContent]);
    rows.sort(([, a, text], [, b, other]) => {
      if (Number.isNaN(a) !== Number.isNaN(b)) return Number.isNaN(a) ? 1 : -1; // no number: last
      const order = Number.isNaN(a) ? text.localeCompare(other) : a - b;
      return isDown ? -order : order;
    });
    body.append(...rows.map(([row]) => row));
  }

  /** Return a table as CSV: each number, and its interval in a column of its own. */
  function csv(table) {
    const quoted = (text) => `"${text.replaceAll('"', '""').replaceAll(/\s+/g, " ").trim()}"`;
    const [head, ...rows] = [table.tHead.rows[0], ...table.tBodies[0].rows].map((row) => [...row.cells]);
    const titles = head.flatMap((cell, i) => (i ? [cell.textContent, `${cell.textContent} interval`] : [cell.textContent]));
    const lines = rows.map((cells) => cells.flatMap((cell, i) => (
      i ? [cell.firstChild?.textContent ?? "", cell.querySelector("small")?.textContent ?? ""] : [cell.textContent]
    )));
    return [titles, ...lines].map((line) => line.map(quoted).join(",")).join("\r\n");
  }

  for (const table of document.querySelectorAll("table")) {
    [...table.tHead.rows[0].cells].forEach((title, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...title.childNodes);
      title.append(button);
      button.addEventListener("click", () => sort(table, column, title));
    });
    const save = document.createElement("a");
    save.className = "save";
    save.textContent = "Download CSV";
    save.download = "table.csv";
    save.href = "#";
    save.addEventListener("click", () => {
      save.href = URL.createObjectURL(new Blob([csv(table)], { type: "text/csv" }));
    });
    table.parentElement.after(save);
  }
  document.documentElement.dataset.tables = "ready";
})();
