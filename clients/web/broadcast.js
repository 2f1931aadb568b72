// A view as HTTP Live Streaming, by HLS.js or a browser that plays it by itself:
// what comes through where live streams do not, from edges that keep copies for
// many. A second or two late, and without the frames' numbers.

import { headers } from "/api.js";
import { Played } from "/played.js";

const RETRY_MS = 2000;
const TYPE = "application/vnd.apple.mpegurl";

let library = null;

function load() {
  library = library ?? new Promise((resolve) => {
    const script = document.createElement("script");
    script.src = "/hls.js";
    script.onload = () => resolve(window.Hls);
    script.onerror = () => resolve(null);
    document.head.append(script);
  });
  return library;
}

export class Broadcast extends Played {
  constructor(name, canvas, told, place = "/v1") {
    super(canvas, told);
    this.url = `${place}/views/${encodeURIComponent(name)}/hls.m3u8`;
  }

  // From the picture's stamp, by the server's clock and ours.
  get latencyMs() {
    const at = this.hls?.playingDate;
    return at ? Math.max(Date.now() - at.getTime(), 0) : undefined;
  }

  close() {
    this.hls?.destroy();
    this.hls = null;
    this.video.removeAttribute("src");
  }

  async open() {
    const Hls = await load();
    if (!this.wanted) {
      return;
    }
    if (Hls?.isSupported()) {
      this.hls = new Hls({
        enableWorker: false, // its script would be of no address of ours
        lowLatencyMode: true,
        xhrSetup: (request) => {
          for (const [name, value] of Object.entries(headers())) {
            request.setRequestHeader(name, value);
          }
        },
      });
      this.hls.on(Hls.Events.ERROR, (_, data) => {
        if (data.fatal) {
          this.lost();
        }
      });
      this.hls.loadSource(this.url);
      this.hls.attachMedia(this.video);
    } else if (this.video.canPlayType(TYPE)) {
      this.video.src = this.url;
      this.video.onerror = () => this.lost();
    } else {
      this.told(null);
      return;
    }
    this.video.play().catch(() => {}); // once there is something to play
    this.watch();
  }

  lost() {
    this.close();
    this.told(null);
    if (this.wanted) {
      this.retry = setTimeout(() => this.open(), RETRY_MS);
    }
  }
}

// Whether this browser plays it.
export const playsBroadcast = "MediaSource" in window ||
  document.createElement("video").canPlayType(TYPE) !== "";
