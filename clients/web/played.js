// What ways that the browser plays by itself, in a video element, share: they
// know when a picture is shown, and not which.

const RATE_WINDOW_MS = 3000;

export class Played {
  // `told` as in stream.js, without the frame's number, its time and `stale`.
  constructor(canvas, told) {
    this.told = told;
    this.stamps = [];
    this.missed = 0;
    this.wanted = false;
    this.video = document.createElement("video");
    this.video.className = "picture";
    this.video.muted = true;
    this.video.playsInline = true;
    this.video.disablePictureInPicture = true;
    this.video.setAttribute("aria-label", canvas.getAttribute("aria-label"));
    this.video.hidden = true;
    canvas.after(this.video);
  }

  get running() {
    return this.wanted;
  }

  get rate() {
    const now = performance.now();
    this.stamps = this.stamps.filter((t) => now - t < RATE_WINDOW_MS);
    const span = now - (this.stamps[0] ?? now);
    return span > 200 ? (this.stamps.length - 1) * 1000 / span : 0;
  }

  start() {
    if (!this.wanted) {
      this.wanted = true;
      this.open();
    }
  }

  stop() {
    this.wanted = false;
    clearTimeout(this.retry);
    this.close();
    this.stamps = [];
  }

  watch() {
    this.video.requestVideoFrameCallback?.((_, facts) => {
      if (this.wanted) {
        this.stamps.push(performance.now());
        this.shown?.(facts);
        this.told({ host: 0 });
        this.watch();
      }
    });
  }
}
