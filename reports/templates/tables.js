// Every table can be sorted by the heads of its columns, and copied as CSV in the order shown. The buttons are made
// here, so that a page without scripts has none.
(() => {
  const shown = (cell) => cell.textContent.trim();
  const raised = {"⁻": "-", "⁰": 0, "¹": 1, "²": 2, "³": 3, "⁴": 4, "⁵": 5, "⁶": 6, "⁷": 7, "⁸": 8, "⁹": 9};

  // The number that a cell begins with: "−0.29", "76.4 %", "1.98 × 10⁻⁵", "0.36 ± 0.03"; else NaN.
  function number(text) {
    const match = text.replace(/−/g, "-").match(/^[-+]?\d+(\.\d+)?(\s×\s10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?/);
    if (!match) return NaN;
    const [value, power] = match[0].split(/\s×\s10/);
    return Number(value) * (power ? 10 ** Number([...power].map((digit) => raised[digit]).join("")) : 1);
  }

  // Numbers before words, and what is not there ("–") last, in either direction.
  function order(a, b, direction) {
    if (a === "–" || b === "–") return (a === "–") - (b === "–");
    const x = number(a), y = number(b);
    if (isNaN(x) !== isNaN(y)) return isNaN(x) - isNaN(y);
    return direction * (isNaN(x) ? a.localeCompare(b) : x - y);
  }

  function sort(table, head) {
    const column = head.cellIndex;
    const direction = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
    for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
    const body = table.tBodies[0];
    const rows = [...body.rows].filter((row) => !row.classList.contains("total") && row.cells.length > column);
    const rest = [...body.rows].filter((row) => !rows.includes(row));
    rows.sort((a, b) => order(shown(a.cells[column]), shown(b.cells[column]), direction));
    body.append(...rows, ...rest);
  }

  // RFC 4180.
  function csv(table) {
    const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
    return [...table.rows].map((row) => [...row.cells].map((cell) => quoted(shown(cell))).join(",") + "\r\n").join("");
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch (error) {  // not allowed here: the older way
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      const done = document.execCommand("copy");
      area.remove();
      if (!done) return "Copying is not allowed here";
    }
    return "Copied";
  }

  function button(text, action) {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = text;
    made.addEventListener("click", action);
    return made;
  }

  for (const table of document.querySelectorAll(".table-box > table")) {
    for (const head of table.tHead.rows[0].cells) {
      const text = shown(head);
      if (text) head.replaceChildren(button(text, () => sort(table, head)));
    }
    const copier = button("Copy as CSV", async () => {
      copier.textContent = await copy(csv(table));
      setTimeout(() => { copier.textContent = "Copy as CSV"; }, 2000);
    });
    table.parentNode.previousElementSibling.append(" ", copier);
  }
})();
