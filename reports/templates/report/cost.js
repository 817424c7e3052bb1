// Accuracy against cost: one group of cases at a time, names when pointed at, the front labelled.

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 60, RIGHT = 30, TOP = 20, BOTTOM = 52;
const SHARES = [0, 20, 40, 60, 80, 90, 95, 98, 99, 99.5, 100];

const SHAPES = {
  o: "M-6,0A6,6 0 1 1 6,0A6,6 0 1 1 -6,0Z",
  s: "M-5.5,-5.5H5.5V5.5H-5.5Z",
  "^": "M0,-7L6.5,5.5H-6.5Z",
  v: "M0,7L6.5,-5.5H-6.5Z",
  D: "M0,-7.5L7.5,0L0,7.5L-7.5,0Z",
  "*": "M0,-8L2,-2.5H8L3,1L5,7L0,3.5L-5,7L-3,1L-8,-2.5H-2Z",
};
const OTHER_SHAPE = "M-7,-2.5H-2.5V-7H2.5V-2.5H7V2.5H2.5V7H-2.5V2.5H-7Z";

function drawn(name, attributes, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function choice(label, values, action) {
  const around = document.createElement("label"), select = document.createElement("select");
  values.forEach((text, n) => select.append(new Option(text, n)));
  select.onchange = action;
  around.append(`${label} `, select);
  return { around, select };
}

// Shares near 100 lie apart, as on the printed figure.
const height = (share) => -Math.log10(Math.max(100.5 - share, 1e-3));

// Size of the drawing, that of the page: text keeps its size on a narrow one.
function sizeOf(figure) {
  const WIDTH = Math.max(300, figure.clientWidth);
  return { WIDTH, HEIGHT: Math.round(Math.min(500, Math.max(320, 0.45 * WIDTH))) };
}

function axes(points, { WIDTH, HEIGHT }) {
  const costs = points.flatMap((p) => p.cost), low = Math.min(...costs), high = Math.max(...costs);
  const from = Math.log10(low) - 0.1, to = Math.log10(high) + 0.25;
  const least = Math.max(0, Math.min(...points.map((p) => p.share[1])) - 3);
  const bottom = height(least), top = height(100);
  return {
    x: (cost) => LEFT + ((Math.log10(cost) - from) / (to - from)) * (WIDTH - LEFT - RIGHT),
    y: (share) => HEIGHT - BOTTOM - ((height(share) - bottom) / (top - bottom)) * (HEIGHT - TOP - BOTTOM),
    WIDTH,
    HEIGHT,
    shares: SHARES.filter((share) => share > least),
    costs: [...Array(Math.floor(to) - Math.ceil(from) + 1).keys()].map((k) => 10 ** (Math.ceil(from) + k)),
  };
}

function grid({ x, y, shares, costs, WIDTH, HEIGHT }, quantity) {
  const plain = (value) => Number(value.toPrecision(3)).toString();
  const parts = [
    ...shares.flatMap((s) => [drawn("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(s), y2: y(s) }), drawn("text", { class: "soft", x: LEFT - 8, y: y(s) + 4, "text-anchor": "end" }, `${s}`)]),
    ...costs.flatMap((c) => [drawn("line", { x1: x(c), x2: x(c), y1: TOP, y2: HEIGHT - BOTTOM }), drawn("text", { class: "soft", x: x(c), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle" }, plain(c))]),
    drawn("text", { class: "soft", x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 8, "text-anchor": "middle" }, "CPU time a layout (ms)"),
    drawn("text", { class: "soft", x: -HEIGHT / 2, y: 14, transform: "rotate(-90)", "text-anchor": "middle" }, `${quantity} (%)`),
  ];
  return drawn("g", { "aria-hidden": "true" }, ...parts);
}

function pointOf(point, { x, y }, tell) {
  const [cx, cy] = [x(point.cost[0]), y(point.share[0])];
  const bars = drawn("g", { class: "bars", stroke: point.colour },
    drawn("path", { d: `M${x(point.cost[1])},${cy}H${x(point.cost[2])}M${cx},${y(point.share[1])}V${y(point.share[2])}`, stroke: point.colour, fill: "none" }));
  const mark = drawn("path", { class: "mark", d: SHAPES[point.marker] ?? OTHER_SHAPE, transform: `translate(${cx},${cy})`, fill: point.face, stroke: point.face === point.colour ? "#ffffff" : point.colour, "stroke-width": 1.5 });
  const told = `${point.title}: ${point.told}, n = ${point.n}`;
  const made = drawn("g", { class: point.front ? "point" : "point behind", tabindex: 0, role: "img", "aria-label": told }, bars, mark);
  made.onmouseenter = made.onfocus = () => tell(point, cx, cy);
  made.onmouseleave = made.onblur = () => tell(null);
  return made;
}

// Labels of the front, each moved down until it lies on no other.
function labels(front, { x, y, WIDTH }) {
  const taken = [];
  return front.map((point) => {
    let [px, py] = [x(point.cost[0]), y(point.share[0]) - 12];
    const half = 3.6 * point.title.length;
    px = Math.min(Math.max(px, LEFT + half), WIDTH - RIGHT - half);
    while (taken.some(([qx, qy, reach]) => Math.abs(qx - px) < reach + half && Math.abs(qy - py) < 15)) py += 15;
    taken.push([px, py, half]);
    return drawn("text", { x: px, y: py, "text-anchor": "middle", "aria-hidden": "true" }, point.title);
  });
}

function costChart(figure, { groups, quantity }) {
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  const svg = drawn("svg", { role: "group", "aria-label": `${quantity} against CPU time` });
  const tell = (point, cx, cy) => {
    tip.hidden = !point;
    if (!point) return;
    const name = document.createElement("b");
    name.textContent = point.title;
    tip.replaceChildren(name, `${point.told}, n = ${point.n}`);
    tip.style.left = `${Math.min(Math.max(cx - 80, 0), Math.max(0, figure.clientWidth - 250))}px`;
    tip.style.top = `${svg.parentElement.offsetTop + cy + 16}px`;
  };
  const engines = [...new Set(groups.flatMap((g) => g.points.map((p) => p.engine)))];
  const draw = () => {
    const all = groups[group.select.value].points;
    const points = all.filter((p) => engine.select.value === "0" || p.engine === engines[engine.select.value - 1]);
    tell(null);
    if (!points.length) return svg.replaceChildren();
    const place = axes(all, sizeOf(figure)), front = points.filter((p) => p.front).sort((a, b) => a.cost[0] - b.cost[0]);
    svg.setAttribute("viewBox", `0 0 ${place.WIDTH} ${place.HEIGHT}`);
    const steps = front.map((p, n) => `${n ? `H${place.x(p.cost[0])}V` : `M${place.x(p.cost[0])},`}${place.y(p.share[0])}`).join("");
    const marks = [...points].sort((a, b) => a.front - b.front).map((p) => pointOf(p, place, tell));
    svg.replaceChildren(grid(place, quantity), drawn("path", { class: "front", d: steps || "M0,0" }), ...marks, ...labels(front, place));
  };
  const bar = document.createElement("div");
  bar.className = "tools";
  const group = choice("cases", groups.map((g) => g.title), draw);
  const engine = choice("engine", ["all", ...engines], draw);
  if (groups.length > 1) bar.append(group.around);
  bar.append(engine.around);
  const around = document.createElement("div");
  around.append(svg);
  figure.prepend(bar, around, tip);
  draw();
  let width = figure.clientWidth;
  new ResizeObserver(() => {
    if (figure.clientWidth === width) return;
    width = figure.clientWidth;
    draw();
  }).observe(figure);
}
