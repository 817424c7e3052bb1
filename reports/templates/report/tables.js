// Tables: sorted by their headers, filtered by words, a few columns first, and downloaded as CSV.

const FEW_COLUMNS = 6, MANY_ROWS = 8;

const MISSING = /^(-|–|)$/;
const cellText = (row, at) => row.cells[at].textContent.trim();

// Numbers before words, what is missing last, whichever way it is sorted.
function compared(a, b, falling) {
  if (MISSING.test(a) || MISSING.test(b)) return MISSING.test(a) - MISSING.test(b);
  const [x, y] = [a, b].map((text) => Number.parseFloat(text.replace(/,/g, "")));
  const way = falling ? -1 : 1;
  if (!Number.isNaN(x) && !Number.isNaN(y)) return way * (x - y);
  return way * a.localeCompare(b);
}

function sortBy(table, at) {
  const headers = [...table.tHead.rows[0].cells];
  const before = headers[at].getAttribute("aria-sort");
  const rises = before ? before === "descending" : !headers[at].classList.contains("number");
  const way = rises ? "ascending" : "descending";
  headers.forEach((th) => th.removeAttribute("aria-sort"));
  headers[at].setAttribute("aria-sort", way);
  const rows = [...table.tBodies[0].rows];
  rows.sort((a, b) => compared(cellText(a, at), cellText(b, at), way === "descending"));
  table.tBodies[0].append(...rows);
}

function csvOf(table) {
  const quoted = (text) => (/^[=+@-]./.test(text) && Number.isNaN(Number(text)) ? `'${text}` : text).replace(/"/g, '""');
  const lines = [...table.rows].map((row) => [...row.cells].map((cell) => `"${quoted(cell.textContent.trim())}"`).join(","));
  return lines.join("\r\n");
}

function button(text, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.onclick = action;
  return made;
}

function download(text, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function tools(table, name) {
  const bar = document.createElement("div"), rows = [...table.tBodies[0].rows];
  bar.className = "tools";
  if (rows.length > MANY_ROWS) {
    const label = document.createElement("label"), input = document.createElement("input"), count = document.createElement("p");
    input.type = "search";
    count.className = "count";
    count.setAttribute("aria-live", "polite");
    label.append("filter ", input);
    input.oninput = () => {
      const words = input.value.trim().toLowerCase();
      rows.forEach((row) => { row.hidden = !row.textContent.toLowerCase().includes(words); });
      count.textContent = `${rows.filter((row) => !row.hidden).length} of ${rows.length} rows`;
    };
    bar.append(label, count);
  }
  const columns = table.tHead.rows[0].cells.length;
  if (columns > FEW_COLUMNS) {
    const toggle = button("", () => {
      const few = table.classList.toggle("few");
      toggle.textContent = few ? `show all ${columns} columns` : "show fewer columns";
      toggle.setAttribute("aria-expanded", !few);
    });
    for (const row of table.rows) [...row.cells].slice(FEW_COLUMNS - 1).forEach((cell) => cell.classList.add("more"));
    toggle.onclick();
    bar.append(toggle);
  }
  if (rows.length > 1) bar.append(button("CSV", () => download(csvOf(table), `${name}.csv`)));
  return bar;
}

function dress(table, name) {
  if (!table.tHead || !table.tBodies.length) return;
  const rows = [...table.rows];
  [...table.tHead.rows[0].cells].forEach((th, at) => {
    const isNumber = th.style.textAlign === "right";
    rows.forEach((row) => row.cells[at].classList.toggle("number", isNumber));
    th.scope = "col";
    const title = button(th.textContent, () => sortBy(table, at));
    th.replaceChildren(title);
  });
  const around = document.createElement("div");
  around.className = "scroll";
  table.replaceWith(around);
  around.append(table);
  const bar = tools(table, name);
  if (bar.childElementCount) around.before(bar);
}

function dressTables() {
  for (const section of document.querySelectorAll("section")) {
    const title = section.querySelector("h2").textContent.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
    const tables = [...section.querySelectorAll("table")];
    tables.forEach((table, n) => dress(table, tables.length > 1 ? `${title}-${n + 1}` : title));
  }
}
