// Cards: their pictures, what is shown of them, and the player of the one that is opened.

const cards = [...document.querySelectorAll("#cards li")];
const dialog = find("dialog");
let pictures = null, shared = null, opened = null, asked = "player";

// A load, seen from high x, y and z.
function draw(canvas, { pallet, boxes: flat, order, marked, amber }) {
  const { ramp, wood, edge } = pictures, mark = amber ? pictures.amber : pictures.red;
  const boxes = [];
  for (let k = 0; k < flat.length; k += 6) boxes.push(flat.slice(k, k + 6));
  const flatPoint = ([x, y, z]) => [(x - z) * 0.866, (x + z) * 0.5 - y];
  const [width, , depth] = pallet, deck = [[0, 0, 0], [width, 0, 0], [width, 0, depth], [0, 0, depth]];
  const corners = boxes.flatMap(([x, y, z, w, h, d]) => [[x, y + h, z], [x + w, y, z], [x + w, y, z + d], [x, y, z + d], [x, y + h, z + d], [x + w, y + h, z]]);
  const points = [...deck, ...corners].map(flatPoint);
  const low = [0, 1].map((k) => Math.min(...points.map((p) => p[k]))), high = [0, 1].map((k) => Math.max(...points.map((p) => p[k])));
  const scale = Math.min((canvas.width - 24) / (high[0] - low[0] || 1), (canvas.height - 24) / (high[1] - low[1] || 1));
  const shift = [canvas.width, canvas.height].map((side, k) => (side - scale * (low[k] + high[k])) / 2);
  const pen = canvas.getContext("2d");
  pen.lineJoin = "round";
  const face = (corners3, colour) => {
    pen.beginPath();
    corners3.map(flatPoint).forEach((p, n) => pen[n ? "lineTo" : "moveTo"](...p.map((v, k) => scale * v + shift[k])));
    pen.closePath();
    pen.fillStyle = colour;
    pen.fill();
    pen.strokeStyle = `${edge}99`;
    pen.stroke();
  };
  const sides = (n, colours) => {
    const [x, y, z, w, h, d] = boxes[n], [X, Y, Z] = [x + w, y + h, z + d];
    face([[x, Y, z], [X, Y, z], [X, Y, Z], [x, Y, Z]], colours[0]);
    face([[X, y, z], [X, Y, z], [X, Y, Z], [X, y, Z]], colours[1]);
    face([[x, y, Z], [X, y, Z], [X, Y, Z], [x, Y, Z]], colours[2]);
  };
  face(deck, wood);
  for (const n of order) sides(n, n === marked ? mark : ramp[Math.floor((ramp.length * n) / boxes.length)]);
  if (marked === null) return;
  pen.globalAlpha = 0.5; // it shines through what stands before it
  sides(marked, [mark[0], mark[0], mark[0]]);
}

function filter() {
  const kind = document.querySelector(".kinds [aria-pressed=true]").dataset.kind;
  const words = find("search").value.trim().toLowerCase();
  let shown = 0;
  for (const card of cards) {
    card.hidden = (kind && card.dataset.kind !== kind && !JSON.parse(card.dataset.badges).includes(kind)) || !card.textContent.toLowerCase().includes(words);
    shown += !card.hidden;
  }
  find("shown").textContent = `${shown} of ${cards.length} shown`;
  find("none").hidden = shown > 0;
}

function sort() {
  const number = (card, name) => Number(card.dataset[name]);
  const by = {
    file: () => 0,
    kind: (a, b) => number(a, "rank") - number(b, "rank"),
    boxes: (a, b) => number(b, "boxes") - number(a, "boxes"),
  }[find("order").value];
  cards.sort((a, b) => by(a, b) || number(a, "number") - number(b, "number"));
  find("cards").append(...cards);
}

const playable = () => cards.filter((card) => !card.hidden && card.querySelector("button"));

// A card has a plan, and where it was repaired the plan that stands.
async function open(card, plan = "player") {
  opened = card;
  asked = plan;
  const { number } = card.dataset;
  for (const [id, of] of [["planned", "player"], ["repaired", "repaired"]]) {
    if (!find(id)) continue;
    find(id).hidden = !find(`repaired-${number}`);
    find(id).setAttribute("aria-pressed", of === plan);
  }
  const page = await unpacked(`${plan}-${number}`);
  if (opened !== card || asked !== plan) return;
  const name = card.querySelector(".name").textContent;
  play(page, shared, name, `${name}: ${plan === "player" ? card.querySelector(".answer").textContent : plan}`);
  history.replaceState(null, "", `#${number}`);
}

function beside(way) {
  const all = playable(), at = all.indexOf(opened);
  if (all.length) open(all[(at + way + all.length) % all.length]);
}

function listen() {
  for (const button of document.querySelectorAll(".kinds button")) {
    button.onclick = () => {
      document.querySelectorAll(".kinds button").forEach((b) => b.setAttribute("aria-pressed", b === button));
      filter();
    };
  }
  find("search").oninput = filter;
  find("order").onchange = sort;
  cards.forEach((card) => { const button = card.querySelector("button"); if (button) button.onclick = () => open(card); });
  find("close").onclick = () => dialog.close();
  find("earlier").onclick = () => beside(-1);
  find("later").onclick = () => beside(1);
  if (find("planned")) {
    find("planned").onclick = () => open(opened);
    find("repaired").onclick = () => open(opened, "repaired");
  }
  dialog.onclose = () => {
    dialog.querySelector("iframe")?.remove();
    history.replaceState(null, "", location.pathname + location.search);
    opened?.querySelector("button")?.focus();
    opened = null;
  };
}

(async () => {
  try {
    pictures = JSON.parse(await unpacked("pictures"));
    shared = JSON.parse(await unpacked("shared"));
    const seen = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        if (!isIntersecting) continue;
        seen.unobserve(target);
        draw(target.querySelector("canvas"), pictures.cards[target.dataset.number]);
      }
    }, { rootMargin: "400px" });
    cards.forEach((card) => seen.observe(card));
    listen();
    filter();
    const first = cards.find((card) => location.hash === `#${card.dataset.number}` && card.querySelector("button"));
    if (first) open(first);
    window.ready = true;
  } catch (error) {
    find("error").hidden = false;
    find("error").textContent = `This page needs a browser of 2023 or later: ${error.message}`;
    throw error;
  }
})();
