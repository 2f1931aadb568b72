// What this page is, and whose work is in it.

import { showTour } from "/tour.js";

let dialog = null;

export async function showAbout() {
  if (!dialog) {
    dialog = document.createElement("dialog");
    dialog.id = "about";
    dialog.className = "login about";
    dialog.setAttribute("aria-labelledby", "about-title");
    dialog.innerHTML = `<h2 id="about-title">Pelagos</h2>
      <p id="about-version"></p>
      <p>The interface that this page uses is described at
        <a href="/v1/openapi.json">/v1/openapi.json</a>.</p>
      <div id="about-plots" hidden><p>Diagrams are drawn by uPlot:</p>
        <pre id="about-licence" tabindex="0"></pre></div>
      <div id="about-hls" hidden><p>HTTP Live Streaming is played by hls.js:</p>
        <pre id="about-hls-licence" tabindex="0"></pre></div>
      <p class="tools-row">
        <button class="button" type="button" id="about-tour">Show the
          introduction again</button>
        <button class="button strong" type="button"
                id="about-close">Close</button></p>`;
    document.body.append(dialog);
    dialog.querySelector("#about-close").addEventListener("click", () =>
      dialog.close());
    dialog.querySelector("#about-tour").addEventListener("click", () => {
      dialog.close();
      showTour(true);
    });
  }
  dialog.showModal();
  const [health, plots, hls] = await Promise.all([fetch("/healthz"),
    fetch("/uplot.txt"), fetch("/hls.txt")]);
  const { version } = health.ok ? await health.json() : {};
  dialog.querySelector("#about-version").textContent = version
    ? `Version ${version}.` : "";
  for (const [box, text, licence] of [["#about-plots", "#about-licence", plots],
    ["#about-hls", "#about-hls-licence", hls]]) {
    dialog.querySelector(box).hidden = !licence.ok;
    dialog.querySelector(text).textContent = licence.ok
      ? await licence.text() : "";
  }
}
