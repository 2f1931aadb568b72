// What an address says the page shows: /?view=port1&hud=0 for the screen of a
// wall. The token is never part of it: it comes behind the # and leaves the
// address at once (api.js).

const LAYOUTS = ["heading", "order", "wall"];
const THEMES = ["dark", "light"];
const WAYS = ["webcodecs", "whep", "mjpeg", "hls"]; // as in player.js

const list = (text) => text === null ? null
  : text.split(",").map((name) => name.trim()).filter(Boolean);
const among = (words, text) => words.includes(text) ? text : null;
const flag = (text) => text === null ? null
  : !["0", "no", "off", "false"].includes(text);

export function read(search) {
  const given = new URLSearchParams(search);
  return {
    view: given.get("view") || null,
    views: list(given.get("views")),
    layout: among(LAYOUTS, given.get("layout")),
    hud: flag(given.get("hud")),
    panel: flag(given.get("panel")),
    plan: flag(given.get("plan")),
    theme: among(THEMES, given.get("theme")),
    way: among(WAYS, given.get("way")),
    step: flag(given.get("step")),
  };
}

// The same as an address; what is null is left out.
export function write(wishes, base = location) {
  const given = new URLSearchParams();
  for (const [name, value] of Object.entries(wishes)) {
    if (value !== null && value !== undefined) {
      given.set(name, typeof value === "boolean" ? Number(value)
        : Array.isArray(value) ? value.join(",") : value);
    }
  }
  const search = String(given).replaceAll("%2C", ",");
  return `${base.origin}${base.pathname}${search ? `?${search}` : ""}`;
}

export const link = read(location.search);

// Of the server's views those that the address names, in its order; all of
// them where it names none.
export function wanted(views) {
  const names = link.view ? [link.view] : link.views;
  return names === null ? views : names.map((name) =>
    views.find((view) => view.name === name)).filter(Boolean);
}

// Names that the address gives and the server has not.
export function missing(views) {
  const names = link.view ? [link.view] : link.views ?? [];
  return names.filter((name) => !views.some((view) => view.name === name));
}
