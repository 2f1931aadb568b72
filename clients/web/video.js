// Live pictures in H.264 over a WebSocket, decoded by WebCodecs: see
// proto/live.md. Each picture is acknowledged when it is decoded, so the
// server sends a slow browser fewer of them.

import { acknowledge, connect } from "/early.js";
import { link } from "/link.js";
import { Held, serverClock, unixMs } from "/step.js";
import { readHead } from "/streamhead.js";

const RETRY_MS = 1000;
const RATE_WINDOW_MS = 3000;
const CLOCK_MS = 5000;
const MAX_ERRORS = 3;
const MAX_REFUSED = 2; // sockets that a server that is well did not open
const VERSION = 1;
const H264 = 1;

async function refusal() {
  if (typeof VideoDecoder === "undefined") {
    return window.isSecureContext
      ? "this browser has no VideoDecoder"
      : "browsers decode video only over https or from localhost";
  }
  const answer = await VideoDecoder.isConfigSupported({
    codec: "avc1.42c01f", optimizeForLatency: true,
  }).catch(() => null);
  return answer?.supported ? "" : "this browser does not decode H.264";
}

// Why this browser cannot play video, or ""; once videoKnown has come.
export let noVideo = "";
export const videoKnown = refusal().then((why) => {
  noVideo = why;
});

// The codec string that a key frame's SPS calls for.
function codecOf(data) {
  for (let i = 0; i + 6 < data.length; i++) {
    const begins = data[i] === 0 && data[i + 1] === 0 && data[i + 2] === 1;
    if (begins && (data[i + 3] & 31) === 7) {
      const hex = [...data.subarray(i + 4, i + 7)]
        .map((byte) => byte.toString(16).padStart(2, "0"));
      return `avc1.${hex.join("")}`;
    }
  }
  return "";
}

export class Video {
  // `told` as in stream.js; `failed(why)` when video will not work here.
  constructor(name, canvas, told, failed, place = "/v1") {
    this.name = name;
    this.place = place;
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.told = told;
    this.failed = failed;
    this.socket = null;
    this.stamps = [];
    this.latencies = [];
    this.missed = 0;
    this.errors = 0;
    this.refused = 0;
    this.server = serverClock;
    this.held = link.step
      ? new Held(this.server, ({ frame, head }) => this.draw(frame, head))
      : null;
  }

  get running() {
    return this.wanted === true;
  }

  get rate() {
    const now = performance.now();
    this.stamps = this.stamps.filter((t) => now - t < RATE_WINDOW_MS);
    const span = now - (this.stamps[0] ?? now);
    return span > 200 ? (this.stamps.length - 1) * 1000 / span : 0;
  }

  // Median from the frame's stamp to its decoded picture, of the last ones.
  get latencyMs() {
    const sorted = [...this.latencies].sort((a, b) => a - b);
    return sorted[sorted.length >> 1];
  }

  start() {
    if (!this.wanted) {
      this.wanted = true;
      this.connect();
    }
  }

  stop() {
    this.wanted = false;
    clearTimeout(this.retry);
    clearInterval(this.asking);
    this.socket?.close();
    this.socket = null;
    this.closeDecoder();
    this.stamps = [];
    this.latencies = [];
  }

  connect() {
    const { socket, kept } = connect(this.name, this.place);
    this.socket = socket;
    socket.onmessage = (event) => {
      if (socket !== this.socket) {
        return;
      }
      if (typeof event.data === "string") {
        this.hear(JSON.parse(event.data));
      } else {
        this.take(event.data);
      }
    };
    socket.onclose = () => {
      if (socket === this.socket) {
        this.lost();
      }
    };
    socket.onopen = () => {
      this.refused = -1; // never any more
      this.askTime();
      this.asking = setInterval(() => this.askTime(), CLOCK_MS);
    };
    if (socket.readyState === WebSocket.OPEN) {
      socket.onopen();
    }
    kept.forEach(socket.onmessage);
  }

  lost() {
    clearInterval(this.asking);
    this.closeDecoder();
    this.socket = null;
    this.told(null);
    if (this.wanted) {
      this.retry = setTimeout(() => this.connect(), RETRY_MS);
      if (this.refused >= 0) {
        this.askWhy();
      }
    }
  }

  // Nothing says why a socket was not opened: the server may be away.
  async askWhy() {
    const well = await fetch("/healthz", { cache: "no-store" })
      .then((answer) => answer.ok, () => false);
    this.refused += well && this.refused >= 0;
    if (this.wanted && this.refused >= MAX_REFUSED) {
      this.giveUp("no WebSocket comes through to the server");
    }
  }

  send(type, fill) {
    const message = new DataView(new ArrayBuffer(16));
    message.setUint8(0, type);
    fill?.(message);
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(message);
    }
  }

  askTime() {
    this.send(4, (m) => m.setFloat64(8, unixMs()));
  }

  hear(message) {
    if (message.type === "time") {
      const bits = new DataView(new ArrayBuffer(8));
      bits.setBigUint64(0, BigInt(`0x${message.echo}`), true);
      this.server.add(bits.getFloat64(0), unixMs(), message.unix * 1000);
    } else if (message.type === "end" && /encoder|codec/.test(message.message)) {
      this.giveUp(`the server says: ${message.message}`);
    }
  }

  giveUp(why) {
    this.stop();
    this.failed(why);
  }

  // --- decoding -------------------------------------------------------------

  closeDecoder() {
    this.held?.clear();
    if (this.decoder && this.decoder.state !== "closed") {
      this.decoder.close();
    }
    this.decoder = null;
    this.codec = "";
    this.heads = new Map();
  }

  openDecoder(codec) {
    this.closeDecoder();
    this.codec = codec;
    this.decoder = new VideoDecoder({
      output: (frame) => this.show(frame),
      error: (error) => this.stumble(error),
    });
    this.decoder.configure({ codec, optimizeForLatency: true });
  }

  stumble(error) {
    this.errors += 1;
    this.closeDecoder();
    if (this.errors >= MAX_ERRORS) {
      this.giveUp(`this browser's decoder fails: ${error.message}`);
    } else {
      this.send(2); // a key frame, please
    }
  }

  take(buffer) {
    const head = readHead(buffer);
    const data = new Uint8Array(buffer, head.size);
    if (head.version !== VERSION || head.kind !== H264) {
      this.giveUp("the server's stream is not understood");
      return;
    }
    this.missed = head.missed;
    if (head.key) {
      const codec = codecOf(data);
      if (codec !== this.codec) {
        this.openDecoder(codec);
      }
    }
    if (!this.decoder) {
      this.acknowledge(head); // waits for a key frame
      return;
    }
    const timestamp = Number(head.number); // simulated time may stand still
    this.heads.set(timestamp, head);
    try {
      this.decoder.decode(new EncodedVideoChunk({
        type: head.key ? "key" : "delta", timestamp, data,
      }));
    } catch (error) {
      this.acknowledge(head);
      this.stumble(error);
    }
  }

  acknowledge(head) {
    acknowledge(this.socket, head.number);
  }

  show(frame) {
    const head = this.heads.get(frame.timestamp);
    this.heads.delete(frame.timestamp);
    if (head) {
      this.errors = 0;
      this.acknowledge(head);
    }
    if (head && this.held && this.server.known) {
      this.held.take(head.presentMs,
        { frame, head, close: () => frame.close() });
    } else {
      this.draw(frame, head);
    }
  }

  draw(frame, head) {
    if (this.canvas.width !== frame.displayWidth ||
        this.canvas.height !== frame.displayHeight) {
      this.canvas.width = frame.displayWidth;
      this.canvas.height = frame.displayHeight;
    }
    this.context.drawImage(frame, 0, 0);
    frame.close();
    if (!head) {
      return;
    }
    this.stamps.push(performance.now());
    this.latencies.push(this.server.nowMs - head.stampMs);
    this.latencies.splice(0, this.latencies.length - 31);
    this.told({ number: Number(head.number), time: head.time,
      drawn: head.drawn, stale: head.stale, poses: head.poses,
      ground: head.ground, host: head.host,
      presentMs: head.presentMs });
  }
}
