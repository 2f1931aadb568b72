// The panel beside the pictures: the rose and the sections.

import { Rose } from "/rose.js";
import { beaufort, Sections, sunFixed } from "/sections.js";
import { followTrains } from "/swell.js";

export class Controls {
  constructor(fields, views, store) {
    this.store = store;
    this.rose = new Rose(document.getElementById("rose"));
    followTrains({}, store.told);
    this.sections = new Sections(fields, views, store);
  }

  // What the server says takes the place of what was expected of it.
  followed(before, after) {
    followTrains(before, after);
  }

  show(renewed) {
    const { state } = this.store;
    this.sections.show(renewed);
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
