// A view by WebRTC, asked for by WHEP (proto/live.md): H.264 that browsers play
// where they decode none for a page by itself, on plain http. Without the
// frames' numbers.

import { headers, Problem } from "/api.js";
import { Played } from "/played.js";

const RETRY_MS = 1000;
const CONNECT_MS = 6000; // longer, and no UDP comes through
const LOOK_MS = 1000;
const MAX_FAILED = 2; // in a row, of connections to a server that answers
const PER_MS = 90; // of RTP's time stamps, which begin anew after 13 hours
const ROUND = 2 ** 32;
const KEPT = 31;

// Why the server does not answer, in its words.
function refusal(text, status) {
  try {
    return new Problem(JSON.parse(text), status);
  } catch {
    return new Problem({}, status); // what stands between has none
  }
}

export const playsPeer = typeof RTCPeerConnection !== "undefined";

export class Peer extends Played {
  // `failed(why)` when it will not work here.
  constructor(name, canvas, told, failed, place = "/v1") {
    super(canvas, told);
    this.url = `${place}/views/${encodeURIComponent(name)}/whep`;
    this.failed = failed;
    this.failures = 0;
    this.latencies = [];
  }

  // Median from the frame's stamp to its shown picture, of the last ones, by the
  // server's clock and ours.
  get latencyMs() {
    const sorted = [...this.latencies].sort((a, b) => a - b);
    return sorted[sorted.length >> 1];
  }

  async open() {
    const peer = new RTCPeerConnection();
    this.peer = peer;
    const { receiver } = peer.addTransceiver("video",
      { direction: "recvonly" });
    if ("jitterBufferTarget" in receiver) {
      receiver.jitterBufferTarget = 0; // the newest picture, as it comes
    }
    peer.ontrack = ({ track }) => {
      this.video.srcObject = new MediaStream([track]);
      this.video.play().catch(() => {}); // once there is something to play
      this.watch();
    };
    // Older browsers tell that of ICE alone.
    peer.onconnectionstatechange = peer.oniceconnectionstatechange = () => {
      if (peer === this.peer && ["failed", "closed", "disconnected"].includes(
        peer.connectionState ?? peer.iceConnectionState)) {
        this.lost("the connection broke");
      }
    };
    this.patience = setTimeout(() =>
      this.lost("no UDP comes through to the server"), CONNECT_MS);
    this.looking = setInterval(() => this.look(), LOOK_MS);
    try {
      await this.agree(peer);
    } catch (error) {
      if (peer === this.peer) {
        // Without a status the server is away, and may come back.
        this.lost(error.message, { counts: error.status !== undefined,
          final: error.status < 500 });
      }
    }
  }

  async agree(peer) {
    await peer.setLocalDescription();
    const answer = await fetch(this.url, { method: "POST",
      body: peer.localDescription.sdp,
      headers: headers({ "Content-Type": "application/sdp" }) });
    const text = await answer.text();
    if (answer.status !== 201) {
      throw refusal(text, answer.status);
    }
    const session = answer.headers.get("Location");
    if (peer !== this.peer) { // stopped meanwhile
      this.leave(session);
      return;
    }
    this.session = session;
    this.epoch = Number(text.match(/^a=mediaclk:direct=(\d+)/m)?.[1] ?? NaN);
    await peer.setRemoteDescription({ type: "answer", sdp: text });
  }

  // The server would find out by itself, later.
  leave(session) {
    fetch(session, { method: "DELETE", headers: headers(), keepalive: true })
      .catch(() => {});
  }

  close() {
    clearTimeout(this.patience);
    clearInterval(this.looking);
    this.peer?.close();
    this.peer = null;
    if (this.session) {
      this.leave(this.session);
    }
    this.session = null;
    this.latencies = [];
    this.video.srcObject = null;
  }

  shown({ rtpTimestamp }) {
    this.failures = 0;
    clearTimeout(this.patience);
    const age = (Date.now() * PER_MS + this.epoch - rtpTimestamp) % ROUND;
    if (age >= 0) { // neither is unknown
      this.latencies.push(age < ROUND / 2 ? age / PER_MS : 0);
      this.latencies.splice(0, this.latencies.length - KEPT);
    }
  }

  lost(why, { counts = true, final = false } = {}) {
    this.close();
    this.told(null);
    if (!this.wanted) {
      return;
    }
    this.failures += counts ? 1 : 0;
    if (this.failures >= MAX_FAILED || final) {
      this.stop();
      this.failed(why);
    } else {
      this.retry = setTimeout(() => this.open(), RETRY_MS);
    }
  }

  async look() {
    const { peer } = this;
    const all = await peer?.getStats().catch(() => null);
    for (const report of all?.values() ?? []) {
      if (report.type === "inbound-rtp") {
        this.missed = report.framesDropped ?? 0;
      }
    }
  }
}
