// One view's pictures, the best way that browser and server agree on: H.264 by
// WebCodecs; or by WebRTC, which plain http permits; or Motion-JPEG; or, where
// live streams do not come through (an edge, no place left), HTTP Live Streaming,
// which is a second late. And the reason why it is not the first.

import { Broadcast, playsBroadcast } from "/broadcast.js";
import { link } from "/link.js";
import { Peer, playsPeer } from "/peer.js";
import { Live } from "/stream.js";
import { noVideo, Video } from "/video.js";

const TITLES = { webcodecs: "H.264", whep: "WebRTC", mjpeg: "Motion-JPEG",
  hls: "HLS" };

export class Player {
  // `told` as in stream.js; `changed()` when the way has changed.
  // place: where the views are, of the live scene or of the debrief's.
  constructor(name, canvas, image, told, changed, place = "/v1") {
    this.canvas = canvas;
    this.image = image;
    this.changed = changed;
    this.why = link.way ? `the address says way=${link.way}` : noVideo;
    const live = place === "/v1";
    const next = (way) => (why) => this.fall(way, why);
    const second = playsPeer && live ? "whep" : "mjpeg";
    this.ways = {
      webcodecs: noVideo ? null
        : new Video(name, canvas, told, (why) =>
          this.fall(/encoder|codec/.test(why) ? "mjpeg" : second, why), place),
      mjpeg: new Live(name, image, told,
        playsBroadcast && live ? next("hls") : null, place),
    };
    // Made when they are wanted: each has an element of the page.
    this.makers = {
      whep: () => new Peer(name, canvas, told, (why) =>
        this.fall("mjpeg", `${this.why}; WebRTC: ${why}`), place),
      hls: () => new Broadcast(name, canvas, told, place),
    };
    this.take(live && link.way && (link.way !== "whep" || playsPeer) &&
      (link.way !== "webcodecs" || !noVideo) ? link.way
      : noVideo ? second : "webcodecs");
  }

  take(way) {
    this.ways[way] = this.ways[way] ?? this.makers[way]();
    this.way = way;
    this.arrange();
  }

  // The way that was taken does not work here.
  fall(way, why) {
    this.current.stop();
    this.why = why;
    this.take(way);
    this.current.start();
    this.changed();
  }

  get title() {
    return TITLES[this.way];
  }

  get current() {
    return this.ways[this.way];
  }

  arrange() {
    this.show(this.way);
  }

  show(way) {
    this.canvas.hidden = way !== "webcodecs";
    this.image.hidden = way !== "mjpeg";
    for (const played of ["whep", "hls"]) {
      if (this.ways[played]) {
        this.ways[played].video.hidden = way !== played;
      }
    }
  }

  get running() {
    return this.current.running;
  }

  get rate() {
    return this.current.rate;
  }

  // From the frame's stamp to its picture, or undefined.
  get latencyMs() {
    return this.current.latencyMs;
  }

  // Pictures that the server did not send to us.
  get missed() {
    return this.current.missed;
  }

  start() {
    this.current.start();
  }

  stop() {
    this.current.stop();
  }

  // A single picture, for views beyond the number of streams.
  once() {
    this.show("mjpeg");
    return this.ways.mjpeg.once();
  }
}
