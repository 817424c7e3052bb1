// The page of a study: tables first, then the charts that a reader can ask.

const CHARTS = { cost: costChart, answers: answerChart };

(async () => {
  try {
    dressTables();
    let shared = null, players = null;
    const open = async (chart, number, name, heading) => {
      shared ??= JSON.parse(await unpacked("shared"));
      players ??= JSON.parse(await unpacked("players"));
      play(players[chart][number], shared, name, heading);
    };
    find("close").onclick = () => find("dialog").close();
    find("dialog").onclose = () => find("dialog").querySelector("iframe")?.remove();
    for (const figure of document.querySelectorAll("figure.chart")) {
      const { name } = figure.dataset, data = JSON.parse(await unpacked(`data-${name}`));
      CHARTS[data.kind](figure, data, (...asked) => open(name, ...asked));
    }
    window.ready = true;
  } catch (error) {
    find("error").hidden = false;
    find("error").textContent = `This page needs a browser of 2023 or later: ${error.message}`;
    throw error;
  }
})();
