// Scenes to begin with: each sets wind, sea, Sun and air at once; the harbour
// also brings the traffic of harbour.json, about own ship.

import { headers } from "/api.js";
import { reckoned, shifted, turned, wrap } from "/geo.js";
import { button } from "/panel.js";

const fine = (angle) => Math.round(wrap(angle) * 100) / 100;
export const LONG_S = 86400; // ships go on that long without new poses

export const ownShip = (state) => {
  const list = state.entities ?? [];
  return list.find((e) => (e.id ?? 0) === (state.ownShip?.entity ?? 1)) ??
    list[0];
};

// The lowest number from `from` on that no entity has.
export function freeId(state, from = 2, taken = new Set()) {
  const ids = new Set((state.entities ?? []).map((e) => e.id ?? 0));
  let id = from;
  while (ids.has(id) || taken.has(id)) {
    id++;
  }
  return id;
}

// Things given by metres ahead of and to starboard of own ship, as entities;
// what is there by the same name is put back to its place.
export function placed(state, things, time) {
  const ship = ownShip(state);
  const here = ship ? reckoned(ship, time, state.clock?.reckoning)
    : { latitude: state.origin?.latitude ?? 52.6,
      longitude: state.origin?.longitude ?? 5.2, heading: 0 };
  const ids = new Map((state.entities ?? []).filter((e) => e !== ship)
    .map((e) => [e.name, e.id ?? 0]));
  const taken = new Set();
  const entities = {};
  for (const { name, model, ahead, right, turn = 0, speed = 0 } of things) {
    const id = ids.get(name) ?? freeId(state, 2, taken);
    taken.add(id);
    const heading = fine(here.heading + turn);
    entities[id] = { name, model, afloat: true, lights: "AUTO", heading,
      course: heading, speed, ...shifted(here, turned([ahead, right], here.heading)) };
  }
  return entities;
}

const air = (elevation, azimuth, visibility) =>
  ({ sunElevation: elevation, sunAzimuth: azimuth, visibility });
const wind = (speed, from, ...swell) => ({ windSpeed: speed,
  windDirection: fine(from), spectrum: "PIERSON_MOSKOWITZ", swell });
const train = (height, period, from, spread = 12) =>
  ({ height, period, direction: fine(from), spread });

// Directions are off the bow, so that each shows what it is about.
const SCENES = {
  Calm: (bow) => ({ sea: wind(2, bow + 60), sky: air(42, fine(bow + 70),
    40000) }),
  Breeze: (bow) => ({ sea: wind(9, bow + 40, train(0.8, 9, bow + 70)),
    sky: air(35, fine(bow + 120), 40000) }),
  Storm: (bow) => ({ sea: wind(24, bow + 25, train(3.5, 13, bow + 10)),
    sky: air(14, fine(bow + 75), 12000) }),
  Sunset: (bow) => ({ sea: wind(5, bow + 50, train(0.6, 10, bow + 30)),
    sky: air(3, fine(bow + 12), 30000) }),
  Harbour: (bow) => ({ sea: wind(4, bow + 70), sky: air(28, fine(bow - 75),
    25000), clock: { reckoning: LONG_S } }),
};

let harbour = null;

async function traffic() {
  harbour = harbour ?? await (await fetch("/harbour.json", { headers: headers() }))
    .json();
  return harbour;
}

export function buildScenes(parent, store, { time, done, failed }) {
  const set = async (name) => {
    try {
      const things = name === "Harbour" ? await traffic() : [];
      await store.ask("scene", (state) => {
        const bow = reckoned(ownShip(state) ?? {}, time()).heading;
        const patch = SCENES[name](bow);
        return things.length === 0 ? patch
          : { ...patch, entities: placed(state, things, time()) };
      }, { sure: 2 });
      done(name);
    } catch (error) {
      failed(error);
    }
  };
  for (const name of Object.keys(SCENES)) {
    button(parent, name, `Scene: ${name.toLowerCase()}`, () => set(name));
  }
}
