// What takes longest begins first, while the rest of the page is on its way:
// the state is asked for, and by it the pictures of its views.

import { inTurn, perform, subprotocols } from "/api.js";
import { link, wanted } from "/link.js";

export const MOST_VIDEOS = 16;
const KEPT = 16; // pictures of a view that nobody has taken up yet
const UNWANTED_MS = 5000;

const early = new Map();

export const firstState = inTurn(() => perform("GET", "/v1/state"));

function open(name, place = "/v1") {
  const url = new URL(`${place}/views/${encodeURIComponent(name)}/live`,
    location.href);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(url, subprotocols());
  socket.binaryType = "arraybuffer";
  return socket;
}

export function acknowledge(socket, number) {
  const message = new DataView(new ArrayBuffer(16));
  message.setUint8(0, 1);
  message.setBigUint64(8, number, true);
  if (socket?.readyState === WebSocket.OPEN) {
    socket.send(message);
  }
}

// Keeps what comes, and lets more come: it will be decoded at once, later.
function keep(socket) {
  const kept = [];
  socket.onmessage = (event) => {
    kept.push(event);
    if (typeof event.data !== "string" && kept.length < KEPT) {
      acknowledge(socket, new DataView(event.data).getBigUint64(8, true));
    }
  };
  return { socket, kept };
}

// The view's socket with what came by it so far, or a new one.
export function connect(name, place) {
  if (place !== "/v1") {
    return { socket: open(name, place), kept: [] };
  }
  const found = early.get(name);
  early.delete(name);
  return found && found.socket.readyState <= WebSocket.OPEN ? found
    : { socket: open(name), kept: [] };
}

function begin(state) {
  if (typeof VideoDecoder === "undefined" || document.hidden ||
      (link.way ?? "webcodecs") !== "webcodecs") {
    return;
  }
  for (const { name } of wanted(state.views ?? []).slice(0, MOST_VIDEOS)) {
    early.set(name, keep(open(name)));
  }
  setTimeout(() => {
    early.forEach(({ socket }) => socket.close());
    early.clear();
  }, UNWANTED_MS);
}

firstState.then(begin, () => {}); // app.js says what went wrong
