// A player in the dialog of a page that holds many: `page` has marks in the places of shared texts.

function play(page, { marks, texts }, name, heading) {
  for (const [key, mark] of Object.entries(marks)) page = page.split(mark).join(texts[key]);
  const frame = document.createElement("iframe");
  frame.title = `Loading of ${name}`;
  frame.srcdoc = page;
  find("dialog").querySelector("iframe")?.remove();
  find("dialog").append(frame);
  find("playing").textContent = heading;
  if (!find("dialog").open) find("dialog").showModal();
}
