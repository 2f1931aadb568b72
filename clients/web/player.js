// One view's pictures, the best way that browser and server agree on: H.264 by
// WebCodecs; or Motion-JPEG; or, where live streams do not come through (an edge,
// no place left), HTTP Live Streaming. And the reason why it is not the first.

import { Broadcast, playsBroadcast } from "/broadcast.js";
import { Live } from "/stream.js";
import { noVideo, Video } from "/video.js";

const TITLES = { webcodecs: "H.264", mjpeg: "Motion-JPEG", hls: "HLS" };

export class Player {
  // `told` as in stream.js; `changed()` when the way has changed.
  // place: where the views are, of the live scene or of the debrief's.
  constructor(name, canvas, image, told, changed, place = "/v1") {
    this.canvas = canvas;
    this.image = image;
    this.changed = changed;
    this.why = noVideo;
    const next = (way) => (why) => this.fall(way, why);
    this.ways = {
      webcodecs: noVideo ? null
        : new Video(name, canvas, told, next("mjpeg"), place),
      mjpeg: new Live(name, image, told,
        playsBroadcast && place === "/v1" ? next("hls") : null, place),
    };
    this.broadcast = () => new Broadcast(name, canvas, told, place);
    this.way = noVideo ? "mjpeg" : "webcodecs";
    this.arrange();
  }

  // The way that was taken does not work here.
  fall(way, why) {
    this.current.stop();
    this.ways[way] ??= this.broadcast();
    this.way = way;
    this.why = why;
    this.arrange();
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
    this.canvas.hidden = this.way !== "webcodecs";
    this.image.hidden = this.way !== "mjpeg";
    if (this.ways.hls) {
      this.ways.hls.video.hidden = this.way !== "hls";
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
    if (this.way === "webcodecs") {
      this.canvas.hidden = true;
      this.image.hidden = false;
    }
    return this.ways.mjpeg.once();
  }
}
