// A clip of a view: the next seconds of its H.264 stream, by a connection of
// its own, so that it works where the browser itself cannot play video.

import { subprotocols } from "/api.js";
import { acknowledge } from "/early.js";
import { mp4, setsOf } from "/mp4.js";
import { readHead } from "/streamhead.js";

const SILENT_MS = 10000;
const MOST_BYTES = 256 * 1024 * 1024;

// Pictures from the first key frame on, for that long, as an MP4 file.
// progress(seconds so far); signal: ends it early, with what there is.
export function record(name, seconds, { progress, signal }) {
  const url = new URL(`/v1/views/${encodeURIComponent(name)}/live`,
    location.href);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(url, subprotocols());
  socket.binaryType = "arraybuffer";
  const pictures = [];
  let [sets, bytes, size] = ["", 0, null];
  return new Promise((resolve, reject) => {
    let silence;
    const stop = () => {
      clearTimeout(silence);
      socket.onclose = socket.onmessage = null;
      socket.close();
      signal.removeEventListener("abort", stop);
      if (pictures.length === 0) {
        reject(new Error("no picture came"));
      } else {
        try {
          resolve(mp4(pictures, ...size));
        } catch (error) {
          reject(error);
        }
      }
    };
    const wait = () => {
      clearTimeout(silence);
      silence = setTimeout(stop, SILENT_MS);
    };
    const take = (buffer) => {
      const head = readHead(buffer);
      acknowledge(socket, head.number);
      const data = new Uint8Array(buffer, head.size);
      const other = head.key && setsOf(data) !== sets;
      if (pictures.length === 0 && !head.key) {
        return; // begins with a key frame
      }
      if (pictures.length > 0 && other) {
        stop(); // another size: the file has one
        return;
      }
      if (pictures.length === 0) {
        sets = setsOf(data);
        size = [head.width, head.height];
      }
      pictures.push({ data, key: head.key, stampMs: head.stampMs });
      bytes += data.length;
      const so = (head.stampMs - pictures[0].stampMs) / 1000;
      progress(so);
      if (so >= seconds || bytes > MOST_BYTES) {
        stop();
      }
    };
    socket.onmessage = (event) => {
      wait();
      if (typeof event.data !== "string") {
        take(event.data);
        return;
      }
      const message = JSON.parse(event.data);
      if (message.type === "end") {
        socket.onclose = null;
        clearTimeout(silence);
        reject(new Error(message.message));
      }
    };
    socket.onclose = stop;
    signal.addEventListener("abort", stop);
    wait();
  });
}
