// The models that the server has: built in, and the files of --models.

import { headers } from "/api.js";

const PATIENCE_MS = 60000; // files that are new to the server are read first
const AGAIN_MS = 1000; // it lists what it has read within seconds

export const GROUPS = [["Ships and boats", (m) => m.builtin && !isMark(m)],
  ["Buoys and beacons", (m) => m.builtin && isMark(m)],
  ["Files", (m) => !m.builtin]];

const MARK = /^(LATERAL|CARDINAL|SAFE_WATER|SPECIAL|ISOLATED|BEACON|LIGHT_FLOAT)/;
const ADRIFT = /^(LIFE_RAFT|PERSON)/;
export const isMark = (model) => MARK.test(model?.class ?? "");
export const isAdrift = (model) => ADRIFT.test(model?.class ?? "");
// A light that stands somewhere: of a mark, or of nothing that could sail.
export const isLight = (entity, model) => entity.light !== undefined &&
  entity.lights !== "OFF" && (isMark(model) ||
    entity.model === undefined && !(entity.speed > 0) && !entity.helm?.on);
export const lower = (word) => word.toLowerCase().replaceAll("_", " ");

export class Catalogue {
  constructor(changed) {
    this.changed = changed;
    this.models = [];
    this.byName = new Map();
  }

  // Beside all other requests: it may take seconds.
  async load() {
    try {
      const answer = await fetch("/v1/models", { cache: "no-store",
        headers: headers(), signal: AbortSignal.timeout(PATIENCE_MS) });
      if (!answer.ok) {
        return;
      }
      this.models = (await answer.json()).models ?? [];
    } catch {
      return; // asked for again when somebody chooses one
    }
    this.byName = new Map(this.models.map((m) => [m.name, m]));
    clearTimeout(this.again);
    this.again = this.models.every((m) => m.bytes || m.error) ? null
      : setTimeout(() => this.load(), AGAIN_MS);
    this.changed();
  }

  of(entity) {
    return this.byName.get(entity?.model?.name);
  }

  // Length, beam, draught and height: as given, or as they follow the length.
  sizes(entity) {
    const own = this.of(entity);
    const given = entity?.model ?? {};
    const scale = own && given.length ? given.length / own.length : 1;
    return Object.fromEntries(["length", "beam", "draught", "height"].map(
      (name) => [name, given[name] ?? (own?.[name] ?? 0) * scale]));
  }

  what(entity) {
    const own = this.of(entity);
    return own ? lower(own.class ?? "OTHER")
      : entity?.model?.name ?? (isLight(entity ?? {}) ? "light" : "no shape");
  }
}
