// What the state says of the daemon's inputs: those that led and fell silent;
// and what a person without a command line can do where nothing else would.

import { Gone, Problem } from "/api.js";
import { reckoned } from "/geo.js";

const NAMES = { cigiStale: "CIGI host", modbusStale: "Modbus",
  nmeaStale: "NMEA 0183", consoleStale: "console",
  otherStale: "a client's source" };

// "CIGI host, console", or "".
export const silentInputs = (state) => Object.entries(NAMES)
  .filter(([field]) => state.sources?.[field])
  .map(([, name]) => name).join(", ");

// Ships that moved and stand at that time, as nobody has sent a new pose.
export function outrun(state, time) {
  const reckoning = state.clock?.reckoning ?? 60;
  const names = (state.entities ?? []).filter((e) => !e.helm?.on &&
    reckoned(e, time, reckoning).stood).map((e) => e.name || `entity ${
    e.id ?? 0}`);
  const who = names.length === 1 ? `${names[0]} stands`
    : names.length > 1 ? `${names.length} ships stand` : "A ship stands";
  return `${who}: no new pose for ${reckoning} s`;
}

// A replay, or a client that is gone, may have left them: nobody else would.
export async function clearSilent(store) {
  try {
    await store.ask("silent", (state) => ({ sources: Object.fromEntries(
      Object.keys(NAMES).filter((field) => state.sources?.[field])
        .map((field) => [field, null])) }));
  } catch (error) {
    if (!(error instanceof Problem || error instanceof Gone)) {
      throw error;
    }
  }
}

// Own ship's bridge or, where there is no ship, 15 m above the origin.
export async function addView(store) {
  const note = document.getElementById("add-view-error");
  try {
    await store.ask("view", (state) => {
      const own = (state.entities ?? []).find((e) => (e.id ?? 0) ===
        (state.ownShip?.entity ?? 1)) ?? state.entities?.[0];
      return { views: { bridge: own ? { entity: own.id ?? 0 } : { up: 15 } } };
    });
    note.hidden = true;
  } catch (error) {
    if (!(error instanceof Problem || error instanceof Gone)) {
      throw error;
    }
    note.textContent = error.line ?? "The server does not answer.";
    note.hidden = false;
  }
}
