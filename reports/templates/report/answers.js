// On how many cases every two methods differ, and which these are; a case opens its player.

const STABLE = -1;

function saidText(value) {
  if (value === null) return "no verdict";
  return value === STABLE ? "stable" : `box ${value + 1}`;
}

// From yellow, where all is the same, to a deep red.
function shadeOf(share) {
  const light = 94 - 44 * Math.min(1, share * 1.6);
  return `hsl(${48 - 40 * Math.min(1, share * 1.6)} 80% ${light}%)`;
}

function answerChart(figure, { methods, cases, played }, open) {
  const [layout, scenario, first] = [0, 1, 2];
  const says = (row, method) => row[first + method];
  // As in the tables: a missing verdict agrees with nothing.
  const differ = (row, a, b) => a !== b && (says(row, a) === null || says(row, a) !== says(row, b));
  const numbers = methods.map((_, a) => methods.map((__, b) => cases.filter((row) => differ(row, a, b)).length));
  const place = new Map(played.map((number, n) => [number, n]));
  const listed = document.createElement("div");
  listed.setAttribute("aria-live", "polite");

  const list = (a, b) => {
    figure.querySelectorAll(".matrix button").forEach((cell) => cell.setAttribute("aria-pressed", cell.dataset.pair === `${a},${b}`));
    [one.select.value, other.select.value] = [a, b];
    const rows = cases.map((row, number) => ({ row, number })).filter(({ row }) => differ(row, a, b));
    const told = document.createElement("p");
    told.textContent = a === b ? "Choose two different methods." : `${methods[a]} and ${methods[b]} differ on ${rows.length} of ${cases.length} cases.`;
    listed.replaceChildren(told);
    if (!rows.length) return;
    const table = document.createElement("table"), head = table.createTHead().insertRow(), body = table.createTBody();
    for (const title of ["layout", "scenario", methods[a], methods[b], "look"]) {
      const th = document.createElement("th");
      th.textContent = title;
      head.append(th);
    }
    for (const { row, number } of rows) {
      const line = body.insertRow(), heading = `${row[layout]}, ${row[scenario]}: ${methods[a]} ${saidText(says(row, a))}, ${methods[b]} ${saidText(says(row, b))}`;
      for (const text of [row[layout], row[scenario], saidText(says(row, a)), saidText(says(row, b))]) line.insertCell().textContent = text;
      const look = line.insertCell();
      if (place.has(number)) look.append(button("play", () => open(place.get(number), row[layout], heading)));
      else look.textContent = "-";
    }
    const around = document.createElement("div");
    around.className = "cases";
    around.append(table);
    listed.append(around);
    dress(table, `${methods[a]} and ${methods[b]}`.replace(/[^A-Za-z0-9]+/g, "-"));
  };

  const matrix = document.createElement("div"), table = document.createElement("table");
  matrix.className = "matrix";
  const head = table.createTHead().insertRow();
  head.append(document.createElement("td"));
  for (const title of methods) {
    const th = document.createElement("th"), span = document.createElement("span");
    span.textContent = title;
    th.append(span);
    head.append(th);
  }
  const body = table.createTBody();
  methods.forEach((title, a) => {
    const line = body.insertRow(), th = document.createElement("th");
    th.textContent = title;
    line.append(th);
    methods.forEach((__, b) => {
      const cell = line.insertCell();
      if (a === b) return;
      const made = button(`${numbers[a][b]}`, () => list(a, b));
      made.tabIndex = -1; // by keyboard the two lists above choose
      made.dataset.pair = `${a},${b}`;
      made.title = `${title} and ${methods[b]} differ on ${numbers[a][b]} of ${cases.length} cases`;
      made.style.background = shadeOf(numbers[a][b] / cases.length);
      cell.append(made);
    });
  });
  matrix.append(table);
  const bar = document.createElement("div");
  bar.className = "tools";
  const chosen = () => list(Number(one.select.value), Number(other.select.value));
  const one = choice("cases on which", methods, chosen), other = choice("differs from", methods, chosen);
  other.select.value = Math.min(1, methods.length - 1);
  bar.append(one.around, other.around, button("list", chosen));
  figure.prepend(bar, matrix, listed);
}
