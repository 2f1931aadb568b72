// The server's HTTP interface: one request at a time, so that the browser's
// few connections to one host are left to the pictures.

const TIMEOUT_MS = 5000;

export class Problem extends Error {
  constructor(body, status) {
    super(body.detail || body.title || `HTTP ${status}`);
    this.status = status;
    this.path = body.path || "";
    this.unit = body.unit && body.unit !== "1" ? body.unit : "";
    this.minimum = body.minimum;
    this.maximum = body.maximum;
  }

  // One line for the place next to a control.
  get line() {
    if (this.minimum === undefined) {
      return this.message;
    }
    const unit = this.unit ? ` ${this.unit}` : "";
    return `Not accepted: must be ${this.minimum} to ${this.maximum}${unit}.`;
  }
}

// Thrown when the server cannot be reached at all.
export class Gone extends Error {}

let last = Promise.resolve();

async function perform(method, path, body, type) {
  let response;
  try {
    response = await fetch(path, {
      method,
      cache: "no-store",
      signal: AbortSignal.timeout(TIMEOUT_MS),
      headers: body === undefined ? {} : { "Content-Type": type },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
  } catch (error) {
    throw new Gone(error.message);
  }
  const text = await response.text().catch((error) => {
    throw new Gone(error.message);
  });
  let json = {};
  try {
    json = text ? JSON.parse(text) : {};
  } catch {
    json = { title: `HTTP ${response.status}` };
  }
  if (!response.ok) {
    throw new Problem(json, response.status);
  }
  return json;
}

function inTurn(work) {
  const turn = last.then(work, work);
  last = turn.catch(() => {});
  return turn;
}

export const getState = () => inTurn(() => perform("GET", "/v1/state"));
export const getFields = () => inTurn(() => perform("GET", "/v1/fields"));
export const patchState = (patch) =>
  inTurn(() => perform("PATCH", "/v1/state", patch,
    "application/merge-patch+json"));
export const stepClock = (seconds) =>
  inTurn(() => perform("POST", "/v1/clock/step", { seconds },
    "application/json"));
