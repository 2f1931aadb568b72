// The machines of an exercise: who seals, who follows, how far behind, whether
// all show the same, and the views that each draws (docs/cluster.md).

import { Gone, inTurn, perform, Problem } from "/api.js";

const LOOK_MS = 1000;
const SAID_FRAMES = 60; // nodes say something once a second
const ROLES = { MASTER: "master", FOLLOWER: "follows", JOINING: "joins" };

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text ?? "";
  return node;
}

// What is elsewhere leads there.
function link(text, address, here) {
  const out = element(here || !address ? "strong" : "a", "", text);
  if (out.tagName === "A") {
    out.href = /^https?:/.test(address) ? address : `http://${address}`;
  }
  return out;
}

const ms = (value) => `${value.toFixed(value < 10 ? 1 : 0)} ms`;
const many = (count, one, more) => `${count} ${Number(count) === 1 ? one : more}`;

// base64 of the first bytes of a digest, as pelagosctl prints it.
export function hex(base64) {
  return [...atob(base64 ?? "")].map((c) =>
    c.charCodeAt(0).toString(16).padStart(2, "0")).join("");
}

export const roleOf = (node) => node.silent ? "silent"
  : ROLES[node.role] ?? (node.role ?? "").toLowerCase();

// What is wrong with a node, in words; nothing: "".
export function faults(node) {
  const said = [];
  if (Number(node.differences ?? 0) > 0) {
    said.push(many(node.differences, "state differed", "states differed"));
  }
  if (Number(node.gaps ?? 0) > 0) {
    said.push(many(node.gaps, "frame missed", "frames missed"));
  }
  if (Math.abs(node.clock ?? 0) > 1) {
    said.push(`its clock is ${ms(Math.abs(node.clock))} ${
      node.clock > 0 ? "ahead" : "behind"}`);
  }
  if (!node.alike) {
    said.push("its pictures are not the master\u2019s to the bit");
  }
  if (node.lacks) {
    said.push(node.lacks);
  }
  return said.join("; ");
}

// Where a view is placed, and who draws it now if that is another.
export function placed(place) {
  const now = place.drawnBy ?? "";
  const drawn = now === place.node ? "and drawn there"
    : now ? `drawn by ${now}` : "drawn by nobody";
  const gone = place.there ? "" : `: ${place.node} is not there`;
  return `placed at ${place.node}, ${drawn}${gone}`;
}

// The newest frame that anybody shows.
export function newest(cluster) {
  return Math.max(Number(cluster.frame ?? 0),
    ...(cluster.nodes ?? []).map((n) => Number(n.frame ?? 0)));
}

export class Machines {
  constructor(details) {
    this.details = details;
    this.box = details.querySelector("#machines-card");
    this.head = element("p", "fine");
    this.head.id = "machines-head";
    this.list = element("ul", "machines-list");
    this.places = element("ul", "machines-list");
    this.places.id = "machines-places";
    this.error = element("p", "error");
    this.error.setAttribute("role", "alert");
    this.error.hidden = true;
    this.box.append(this.head, this.list, this.places, this.error);
    this.rows = new Map();
    details.addEventListener("toggle", () => this.look());
    this.look();
  }

  async look() {
    clearTimeout(this.timer);
    if (!this.details.open) {
      return;
    }
    try {
      this.show(await inTurn(() => perform("GET", "/v1/cluster")));
      this.error.hidden = true;
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.error.textContent = error instanceof Gone
        ? "The server does not answer." : error.message;
      this.error.hidden = false;
    }
    this.timer = setTimeout(() => this.look(), LOOK_MS);
  }

  show(cluster) {
    const nodes = [...(cluster.nodes ?? [])].sort((a, b) =>
      (b.role === "MASTER") - (a.role === "MASTER") ||
      a.name.localeCompare(b.name));
    const sealed = cluster.sealedP99 === undefined ? ""
      : `; sealed within ${ms(cluster.sealedMedian)}, 99 of 100 within ${
        ms(cluster.sealedP99)}`;
    this.head.textContent = cluster.master
      ? `${cluster.master} takes the edits${sealed}.`
      : "Nobody takes edits now.";
    const last = newest(cluster);
    for (const [name, row] of this.rows) {
      if (!nodes.some((n) => n.name === name)) {
        row.remove();
        this.rows.delete(name);
      }
    }
    for (const node of nodes) {
      this.showNode(node, last, node.name === cluster.name);
    }
    this.places.replaceChildren(...(cluster.places ?? []).map((place) =>
      this.rowOf(place, place.drawnBy === cluster.name)));
    this.places.hidden = !this.places.children.length;
  }

  rowOf(place, here) {
    const row = element("li", "machine");
    const head = element("p", "machine-head");
    head.append(link(place.view, place.address, here));
    row.dataset.view = place.view;
    row.classList.toggle("away", place.drawnBy !== place.node);
    row.append(head, element("p", "fine", placed(place)));
    return row;
  }

  showNode(node, last, here) {
    const row = this.rows.get(node.name) ?? element("li", "machine");
    this.rows.set(node.name, row);
    const head = element("p", "machine-head");
    const name = link(node.name, node.address, here);
    const role = element("span", "phase", roleOf(node) +
      (node.spare ? ", spare" : "") + (here ? ", here" : ""));
    head.append(name, role);
    const behind = last - Number(node.frame ?? 0);
    const figures = element("p", "fine", `frame ${node.frame ?? 0}${
      behind > SAID_FRAMES ? `, ${behind} behind` : ""}, delay ${ms(node.delay ?? 0)}, ` +
      `state ${hex(node.digest) || "\u2013"}`);
    const views = element("p", "fine", (node.views ?? []).length
      ? `draws ${node.views.join(", ")}` : "draws no live view");
    const wrong = element("p", "machine-fault", faults(node));
    wrong.hidden = !wrong.textContent;
    row.dataset.node = node.name;
    row.dataset.role = roleOf(node);
    row.classList.toggle("silent", Boolean(node.silent));
    row.replaceChildren(head, figures, views, wrong);
    this.list.append(row);
  }
}
