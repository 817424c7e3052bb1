// Cards: their pictures, what is shown of them, and the player of the one that is opened.

const cards = [...document.querySelectorAll("#cards li")];
const dialog = find("dialog");
let shared = null, opened = null, asked = "player";

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
    const pictures = JSON.parse(await unpacked("pictures"));
    shared = JSON.parse(await unpacked("shared"));
    for (const card of cards) card.querySelector(".picture").innerHTML = pictures[card.dataset.number] ?? "";
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
