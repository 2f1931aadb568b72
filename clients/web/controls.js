// The panel beside the pictures: the rose and the sections.

import { inTurn, perform } from "/api.js";
import { Debrief, Recordings } from "/debrief.js";
import { Keep } from "/keep.js";
import { Presets } from "/presets.js";
import { dress, may } from "/rights.js";
import { Rose } from "/rose.js";
import { beaufort, Sections, sunFixed } from "/sections.js";
import { utcMs } from "/daytime.js";
import { followTrains } from "/swell.js";
import { Traffic } from "/traffic.js";
import { ViewList } from "/viewlist.js";

export class Controls {
  // time(): simulated time of the pictures.
  constructor(fields, views, store, time) {
    this.store = store;
    this.rose = new Rose(document.getElementById("rose"));
    followTrains({}, store.told);
    this.traffic = new Traffic({ store, views, time,
      chosen: (id) => this.choose(id) });
    this.sections = new Sections(fields, views, store, this.traffic, time);
    this.presets = new Presets(store, fields, time);
    this.keep = new Keep(views, () => {
      const ms = utcMs(store.state, time());
      return Number.isFinite(ms) ? new Date(ms) : null;
    });
    const byId = (id) => document.getElementById(id);
    this.viewList = new ViewList(byId("viewlist"), store, views);
    this.debrief = new Debrief(views);
    this.recordings = new Recordings(byId("recordings"), this.debrief);
    this.lazyCard("sea-state", async (details) => {
      const { SeaCard } = await import("/seacard.js");
      return new SeaCard(details, store, time);
    });
    this.lazyCard("exercises", async (details) => {
      const { Exercises } = await import("/exercises.js");
      return new Exercises(details, store);
    });
    this.machines();
    dress();
  }

  // Shown where the server shows an exercise with others.
  async machines() {
    const details = document.getElementById("machines");
    const said = may("GET v1/cluster")
      ? await inTurn(() => perform("GET", "/v1/cluster")).catch(() => ({}))
      : {};
    details.hidden = !said.name;
    if (said.name) {
      this.lazyCard("machines", async () => {
        const { Machines } = await import("/machines.js");
        return new Machines(details);
      });
    }
  }

  // A card that is made when it is opened first.
  lazyCard(id, make) {
    const details = document.getElementById(id);
    let made = null;
    const open = () => {
      if (details.open) {
        made = made ?? make(details);
      }
    };
    details.addEventListener("toggle", open);
    open();
  }

  // What the server says takes the place of what was expected of it.
  followed(before, after) {
    followTrains(before, after);
  }

  // id: of an entity; none: what models there are is known now.
  choose(id) {
    if (this.sections && id !== undefined) {
      this.sections.shipId = String(id);
    }
    this.show(id !== undefined);
  }

  show(renewed) {
    const { state } = this.store;
    this.sections.show(renewed);
    this.traffic.show();
    this.presets.show(state);
    this.viewList.show(state);
    if (renewed) {
      this.debrief.showViews();
    }
    const wind = state.sea?.windSpeed ?? 0;
    this.rose.show({
      wind: state.sea?.windDirection ?? 0, speed: wind, force: beaufort(wind),
      sun: sunFixed(state) ? state.sky.sunAzimuth : undefined,
      ship: this.sections.ship(state)?.heading,
    });
  }

  // The server answers.
  heard() {
    this.sections.heard();
  }
}
