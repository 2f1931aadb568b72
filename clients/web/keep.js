// Pictures and clips of the chosen view as files.

import { Gone, headers, Problem } from "/api.js";
import { button } from "/panel.js";

const PATIENCE_MS = 120000; // a large EXR on the software device
const KINDS = [["jpg", "JPEG"], ["png", "PNG"], ["exr", "EXR"]];
const byId = (id) => document.getElementById(id);

export function hand(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// bridge-2026-06-21T120304Z.jpg
function fileName(view, utc, ending) {
  const when = utc ? `-${utc.toISOString().slice(0, 19).replaceAll(":", "")}Z`
    : "";
  return `${view}${when}.${ending}`;
}

export class Keep {
  // views: the grid; utc(): of the picture that is shown, a Date or null.
  constructor(views, utc) {
    this.views = views;
    this.utc = utc;
    this.note = byId("keep-note");
    for (const [ending, text] of KINDS) {
      button(byId("keep-pictures"), text, `Save a picture as ${text}`,
        () => this.picture(ending));
    }
    this.clip = button(byId("keep-clip"), "Record a clip",
      "Record the next seconds as MP4", () => this.record());
    this.seconds = byId("clip-seconds");
  }

  say(text, wrong = false) {
    this.note.textContent = text;
    this.note.classList.toggle("error", wrong);
    this.note.hidden = text === "";
  }

  async picture(ending) {
    const { name } = this.views;
    if (!name) {
      this.say("There is no view to save.", true);
      return;
    }
    this.say(`Asking for ${name}.${ending} …`);
    try {
      const answer = await fetch(
        `/v1/views/${encodeURIComponent(name)}/frame.${ending}`,
        { cache: "no-store", headers: headers(),
          signal: AbortSignal.timeout(PATIENCE_MS) });
      if (!answer.ok) {
        const body = await answer.json().catch(() => ({}));
        throw new Problem(body, answer.status);
      }
      const file = fileName(name, this.utc(), ending);
      hand(await answer.blob(), file);
      this.say(`Saved ${file}.`);
    } catch (error) {
      this.say(error instanceof Problem ? error.message
        : "Not saved: the server does not answer.", true);
    }
  }

  async record() {
    if (this.abort) {
      this.abort.abort();
      return;
    }
    const { name } = this.views;
    const seconds = Number(this.seconds.value);
    if (!name || !(seconds >= 1 && seconds <= 600)) {
      this.say(name ? "A clip has 1 to 600 seconds."
        : "There is no view to record.", true);
      return;
    }
    this.abort = new AbortController();
    this.clip.textContent = "End the clip";
    try {
      const { record } = await import("/clip.js");
      this.say("Recording …");
      const blob = await record(name, seconds, { signal: this.abort.signal,
        progress: (so) => this.say(
          `Recording: ${so.toFixed(1)} of ${seconds} s`) });
      const file = fileName(name, this.utc(), "mp4");
      hand(blob, file);
      this.say(`Saved ${file}, ${(blob.size / 1e6).toFixed(1)} MB.`);
    } catch (error) {
      this.say(`No clip: ${error instanceof Gone ? "the server is gone"
        : error.message}.`, true);
    }
    this.abort = null;
    this.clip.textContent = "Record a clip";
  }
}
