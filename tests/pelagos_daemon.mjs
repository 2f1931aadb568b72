// Starts pelagosd (and nginx before it) for a test in JavaScript.
import { spawn } from "node:child_process";
import dgram from "node:dgram";
import { once } from "node:events";
import fs from "node:fs";
import net from "node:net";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

export const ROOT = path.dirname(path.dirname(fileURLToPath(import.meta.url)));
const BIN = process.env.PELAGOS_BIN ?? path.join(ROOT, "build/release/bin");
// What "at once" may take, as in pelagos_daemon.py.
export const SANITIZED = BIN.includes("tsan") || BIN.includes("asan");
const SLOW_MS = SANITIZED ? 240000 : 60000;

export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

export async function until(what, test, ms = SLOW_MS) {
  const end = performance.now() + ms;
  let last;
  while (performance.now() < end) {
    try {
      const found = await test();
      if (found) {
        return found;
      }
    } catch (error) {
      last = error; // the page may be redrawing itself
    }
    await sleep(50);
  }
  throw new Error(`not within ${ms / 1000} s: ${what}${last ? `: ${last}` : ""}`);
}

export function folder() {
  return fs.mkdtempSync(path.join(os.tmpdir(), "pelagos-page-"));
}

// Of those that tests/run keeps for this test; none of those that the kernel
// gives to clients, of this test or another.
export async function freePort(kind = "tcp") {
  const [first, last] = (process.env.PELAGOS_TEST_PORTS ?? "10000-32767")
    .split("-").map(Number);
  for (;;) {
    const port = first + Math.floor(Math.random() * (last - first + 1));
    const socket = kind === "udp"
      ? dgram.createSocket("udp4").bind(port, "127.0.0.1")
      : net.createServer().listen(port, "127.0.0.1");
    const free = await new Promise((done) => {
      socket.on("listening", () => done(true)).on("error", () => done(false));
    });
    if (free) {
      socket.close();
      await once(socket, "close");
      return port;
    }
  }
}

export class Daemon {
  static async start(options = [], port = 0, env = {}) {
    const daemon = new Daemon();
    daemon.said = "";
    daemon.process = spawn(path.join(BIN, "pelagosd"), [
      "--http", `127.0.0.1:${port}`, "--tcp", "off", "--rtsp", "off",
      "--modbus", "off", "--nmea", "off", "--device", "software", ...options,
    ], { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, ...env } });
    for (const stream of [daemon.process.stdout, daemon.process.stderr]) {
      stream.on("data", (data) => {
        daemon.said += data;
      });
    }
    const line = await until("pelagosd listens", () => {
      if (daemon.process.exitCode !== null) {
        throw new Error(daemon.said);
      }
      return daemon.said.match(/NET-002 .*:(\d+)\//);
    });
    daemon.port = Number(line[1]);
    daemon.url = `http://127.0.0.1:${daemon.port}`;
    return daemon;
  }

  async request(method, place, body, token = this.token) {
    const answer = await fetch(this.url + place, {
      method,
      headers: { "Content-Type": "application/json",
        ...(token ? { Authorization: `Bearer ${token}` } : {}) },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
    const text = await answer.text();
    if (!answer.ok) {
      throw new Error(`${method} ${place}: ${answer.status} ${text}`);
    }
    return text ? JSON.parse(text) : null;
  }

  patch(change) {
    return this.request("PATCH", "/v1/state", change);
  }

  state() {
    return this.request("GET", "/v1/state");
  }

  async metric(name) {
    const answer = await fetch(`${this.url}/metrics`);
    const line = (await answer.text()).split("\n").find((l) =>
      l.startsWith(`${name} `));
    return Number(line.slice(name.length));
  }

  async stop(signal = "SIGTERM") {
    if (this.process.exitCode === null) {
      this.process.kill(signal);
      await once(this.process, "exit");
    }
  }
}

// The configuration that ships, with the ports and certificate of a test.
export class Proxy {
  static async start(daemon, cert, key) {
    const proxy = new Proxy();
    const [plain, secure] = [await freePort(), await freePort()];
    const home = folder();
    const shipped = fs.readFileSync(
      path.join(ROOT, "packaging/nginx/pelagos.conf"), "utf8");
    fs.writeFileSync(path.join(home, "pelagos.conf"), shipped
      .replaceAll("127.0.0.1:8080", `127.0.0.1:${daemon.port}`)
      .replace(/listen 80;/, `listen 127.0.0.1:${plain};`)
      .replace(/listen 443 ssl;/, `listen 127.0.0.1:${secure} ssl;`)
      .replace(/ *listen \[::\].*\n/g, "")
      .replaceAll("ocean.example", "localhost")
      .replace("/etc/pelagos/tls/fullchain.pem", cert)
      .replace("/etc/pelagos/tls/privkey.pem", key));
    fs.writeFileSync(path.join(home, "nginx.conf"), `
      daemon off; master_process off; pid ${home}/pid;
      error_log ${home}/error.log; events { worker_connections 256; }
      http { access_log off; client_body_temp_path ${home}/a;
        proxy_temp_path ${home}/b; fastcgi_temp_path ${home}/c;
        uwsgi_temp_path ${home}/d; scgi_temp_path ${home}/e;
        include ${home}/pelagos.conf; }`);
    proxy.process = spawn("nginx", ["-p", home, "-c", `${home}/nginx.conf`,
      "-e", `${home}/error.log`], { stdio: "ignore" });
    proxy.home = home;
    proxy.plainPort = plain;
    proxy.port = secure;
    proxy.url = `https://localhost:${secure}`;
    await until("nginx listens", () => {
      if (proxy.process.exitCode !== null) {
        throw new Error(proxy.errors());
      }
      return new Promise((done) => {
        const socket = net.connect(secure, "127.0.0.1");
        socket.on("connect", () => done(true)).on("error", () => done(false));
        socket.on("connect", () => socket.destroy());
      });
    });
    return proxy;
  }

  errors() {
    return fs.readFileSync(path.join(this.home, "error.log"), "utf8");
  }

  async stop() {
    if (this.process.exitCode === null) {
      this.process.kill("SIGTERM");
      await once(this.process, "exit");
    }
    fs.rmSync(this.home, { recursive: true });
  }
}
