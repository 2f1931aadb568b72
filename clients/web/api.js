// The server's HTTP interface: one request at a time, so that the browser's
// few connections to one host are left to the pictures. A server that asks for
// a token gets it from the address (#token=…) or from a person; it is kept as
// long as the tab.

const TIMEOUT_MS = 5000;
// The server makes a sea or a shape, or reads a file, before it takes an edit.
const EDIT_MS = 60000;
const KEY = "pelagos-token";

export class Problem extends Error {
  constructor(body, status) {
    super(body.detail || body.title || `HTTP ${status}`);
    this.status = status;
    this.path = body.path || "";
    this.value = body.value;
    this.unit = body.unit && body.unit !== "1" ? body.unit : "";
    this.minimum = body.minimum;
    this.maximum = body.maximum;
  }

  // One line for the place next to a control: the field, what was asked of
  // it, and what it takes.
  get line() {
    if (this.minimum === undefined) {
      return this.message;
    }
    const unit = this.unit ? ` ${this.unit}` : "";
    const given = this.value === undefined ? "" : ` = ${this.value}${unit}`;
    return `Not accepted: ${this.path}${given}. Give it ${this.minimum} to ` +
      `${this.maximum}${unit}.`;
  }
}

// Thrown when the server cannot be reached at all.
export class Gone extends Error {}

// --- the token ----------------------------------------------------------------

// Out of the address, where it would end in bookmarks and over shoulders.
function takeFromAddress() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem(KEY, given);
    history.replaceState(null, "", location.pathname + location.search);
  }
}
takeFromAddress();
addEventListener("hashchange", takeFromAddress);

const token = () => sessionStorage.getItem(KEY) ?? "";

export function setToken(text) {
  sessionStorage.setItem(KEY, text);
}

export function headers(more = {}) {
  return token() ? { ...more, Authorization: `Bearer ${token()}` } : more;
}

// A WebSocket takes no headers from a page: the token is a subprotocol's name.
export const subprotocols = () =>
  token() ? ["pelagos", `bearer.${token()}`] : [];

// --- requests -------------------------------------------------------------------

let last = Promise.resolve();

// One after the other.
export function inTurn(work) {
  const turn = last.then(work, work);
  last = turn.catch(() => {});
  return turn;
}

async function asked(method, path, body, more) {
  let response;
  try {
    response = await fetch(path, {
      method,
      cache: "no-store",
      signal: AbortSignal.timeout(method === "GET" ? TIMEOUT_MS : EDIT_MS),
      headers: headers(more),
      body: body === undefined ? undefined : JSON.stringify(body),
    });
  } catch (error) {
    throw new Gone(error.message);
  }
  return response;
}

const lost = (error) => {
  throw new Gone(error.message);
};

// Numbers as the server has them, of 32 bits each.
export async function floats(path) {
  const response = await asked("GET", path);
  if (!response.ok) {
    throw new Problem(await response.json().catch(() => ({})),
      response.status);
  }
  const data = new DataView(await response.arrayBuffer().catch(lost));
  return Float32Array.from({ length: data.byteLength / 4 }, (_, i) =>
    data.getFloat32(4 * i, true));
}

export async function perform(method, path, body, more) {
  const response = await asked(method, path, body, more);
  const notice = response.headers.get("X-Pelagos-Notice");
  if (notice) { // what the edit switched off besides
    dispatchEvent(new CustomEvent("pelagos-notice", { detail: notice }));
  }
  const text = await response.text().catch(lost);
  let json = {};
  try {
    json = text ? JSON.parse(text) : {};
  } catch {
    json = { title: `HTTP ${response.status}` };
  }
  if (response.status === 502 || response.status === 504) {
    throw new Gone("the proxy does not reach pelagosd");
  }
  if (!response.ok) {
    throw new Problem(json, response.status);
  }
  return json;
}
