// One view's pictures, the best way that browser and server agree on: H.264 by
// WebCodecs, or Motion-JPEG and the reason for it.

import { Live } from "/stream.js";
import { noVideo, Video } from "/video.js";

export class Player {
  // `told` as in stream.js; `changed()` when the way has changed.
  // place: where the views are, of the live scene or of the debrief's.
  constructor(name, canvas, image, told, changed, place = "/v1") {
    this.canvas = canvas;
    this.image = image;
    this.changed = changed;
    this.why = noVideo;
    this.jpeg = new Live(name, image, told, place);
    this.video = noVideo ? null : new Video(name, canvas, told, (why) => {
      this.why = why;
      this.arrange();
      this.jpeg.start();
      changed();
    }, place);
    this.arrange();
  }

  get way() {
    return this.why ? "mjpeg" : "webcodecs";
  }

  get current() {
    return this.why ? this.jpeg : this.video;
  }

  arrange() {
    this.canvas.hidden = this.why !== "";
    this.image.hidden = this.why === "";
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
    if (!this.why) {
      this.canvas.hidden = true;
      this.image.hidden = false;
    }
    return this.jpeg.once();
  }
}
