// What this page's token may do. The server says it (/v1/session), of its one
// table of roles; the page offers nothing else. Until it is known, and where
// the server asks for no token, that is everything.

import { inTurn, perform } from "/api.js";

let role = "instruct";
let routes = null; // null: every one
let fields = new Set(["*"]);

export const everything = () => fields.has("*");

// "POST v1/exercise", as the server has it; else a field's path.
export const may = (what) => what.includes(" ") ? !routes || routes.has(what)
  : everything() || fields.has(what);

export const roleNow = () => role;

// --- patches ------------------------------------------------------------------

function* leaves(value, path) {
  const within = value !== null && typeof value === "object" &&
    !Array.isArray(value) ? Object.entries(value) : [];
  if (within.length === 0) {
    yield [path, value];
  }
  for (const [name, part] of within) {
    yield* leaves(part, [...path, name]);
  }
}

const isOwn = (state, id) => String(state.ownShip?.entity ?? 1) === id &&
  (state.entities ?? []).some((e) => String(e.id ?? 0) === id);
const isView = (state, name) => (state.views ?? []).some((v) =>
  v.name === name);

// The path as the table has it; "": in no row.
function rule([part, name, ...rest], state) {
  if (part === "entities") {
    return isOwn(state, name) ? ["entities", "own", ...rest].join(".") : "";
  }
  if (part === "views") {
    return isView(state, name) ? ["views", "*", ...rest].join(".") : "";
  }
  return [part, name, ...rest].join(".");
}

// A merge patch of this state. Who may set some fields may take none away, and
// replace no list.
export function mayPatch(patch, state) {
  return everything() || [...leaves(patch, [])].every(([path, value]) =>
    value !== null && !Array.isArray(value) && fields.has(rule(path, state)));
}

// --- the page -------------------------------------------------------------------

// data-needs: what is needed, of several all, separated by commas. Of those who
// may not, an entry rests and anything else is not shown.
export function dress(root = document) {
  for (const node of root.querySelectorAll("[data-needs]")) {
    const barred = !node.dataset.needs.split(",").every((what) =>
      may(what.trim()));
    if (node.matches("input, select")) {
      node.disabled = barred;
    } else {
      node.classList.toggle("barred", barred);
    }
  }
}

export function needs(node, what) {
  node.dataset.needs = what;
  node.classList.toggle("barred", !may(what));
  return node;
}

const WORDS = { watch: ["Watching", "This token reads and streams."],
  steer: ["Steering",
    "This token steers own ship and turns the views; the rest it sees."] };

export async function learn() {
  const session = await inTurn(() => perform("GET", "/v1/session"));
  role = session.role;
  routes = new Set(session.routes);
  fields = new Set(session.fields);
  document.body.dataset.role = role;
  const node = document.getElementById("role");
  [node.textContent, node.title] = WORDS[role] ?? ["", ""];
  node.hidden = !node.textContent;
  dress();
}
