// Views and the page itself: views are added, named, ordered and removed, laid
// out by where they look or in their order, and an address says it again.

import { Gone, Problem } from "/api.js";
import { link, write } from "/link.js";
import { button } from "/panel.js";
import { may } from "/rights.js";
import { chooseTheme, chosenTheme } from "/theme.js";

const SURE_MS = 4000;
const APART = 60; // degrees between a view and the next

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

// The first of "view 2", "view 3" … that there is not.
function freeName(views) {
  const names = new Set(views.map((view) => view.name));
  let i = views.length + 1;
  while (names.has(`view${i}`)) {
    i++;
  }
  return `view${i}`;
}

const half = (angle) => ((angle + 180) % 360 + 360) % 360 - 180;

export class ViewList {
  constructor(parent, store, views) {
    this.store = store;
    this.views = views;
    this.rows = element("ol", "view-rows");
    this.note = element("p", "plan-note");
    this.note.setAttribute("role", "status");
    this.note.hidden = true;
    const tools = element("p", "tools-row");
    button(tools, "Add a view", "Add a view beside the chosen one",
      () => this.add(), "views");
    parent.append(this.rows, tools, this.note);
    this.pick(parent, "layout", "Laid out", [["heading", "By where they look"],
      ["order", "In this order"]], views.layout, (v) => views.setLayout(v));
    this.pick(parent, "theme", "Colours", [["system", "As the system has"],
      ["dark", "Dark"], ["light", "Light"]], chosenTheme(), chooseTheme);
    const links = element("p", "tools-row");
    button(links, "Link to this page", "Copy an address of the page as it is",
      () => this.copy(this.wishes()));
    button(links, "Link to this view",
      "Copy an address of the chosen view alone, for a wall", () =>
        this.copy({ view: this.views.name, hud: false }));
    button(links, "Link to all, as a wall",
      "Copy an address of all views in one row, for a wall", () =>
        this.copy({ layout: "wall", hud: false }));
    this.address = element("output", "address");
    this.address.hidden = true;
    parent.append(links, this.address);
  }

  pick(parent, id, label, options, value, chosen) {
    const node = element("div", "control");
    const name = element("label", "label", label);
    const select = element("select", "select");
    select.id = `page-${id}`;
    name.htmlFor = select.id;
    select.append(...options.map(([v, text]) => {
      const option = element("option", "", text);
      option.value = v;
      return option;
    }));
    select.value = value;
    select.addEventListener("change", () => chosen(select.value));
    node.append(name, select);
    parent.append(node);
    this[id] = select;
  }

  say(text) {
    this.note.textContent = text;
    this.note.hidden = !text;
  }

  // make(views): the list that is to be; null: nothing.
  async do(make) {
    try {
      await this.store.ask("views", (state) => {
        const list = make(state.views ?? []);
        return list && { views: list };
      }, { sure: 2 });
      this.say("");
      return true;
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.say(error.line ?? "Not sent: the server does not answer.");
      return false;
    }
  }

  // As the chosen one, but looking where that does not.
  async add() {
    const { name: from } = this.views;
    let name;
    const there = await this.do((views) => {
      const like = views.find((view) => view.name === from);
      name = freeName(views);
      return [...views, { ...like ?? { width: 640, height: 360 }, name,
        yaw: half((like?.yaw ?? 0) + APART) }];
    });
    if (there) {
      this.views.choose(name);
    }
  }

  rename(from, to) {
    if (to && to !== from) {
      this.do((views) => views.some((view) => view.name === from)
        ? views.map((view) => view.name === from ? { ...view, name: to } : view)
        : null);
      this.renamed = to;
    }
  }

  async move(name, by) {
    await this.do((views) => {
      const at = views.findIndex((view) => view.name === name);
      const to = at + by;
      if (at < 0 || to < 0 || to >= views.length) {
        return null;
      }
      const list = [...views];
      list.splice(to, 0, ...list.splice(at, 1));
      return list;
    });
    this.layout.value = "order";
    this.views.setLayout("order");
  }

  // The second press within some seconds does it.
  remove(name, node) {
    if (this.asked === name) {
      this.asked = null;
      this.do((views) => views.filter((view) => view.name !== name));
      return;
    }
    this.asked = name;
    node.textContent = "Sure?";
    setTimeout(() => {
      this.asked = null;
      node.textContent = "×";
    }, SURE_MS);
  }

  // What the page shows now.
  wishes() {
    const pressed = (id) => document.getElementById(id).getAttribute(
      "aria-pressed") === "true";
    return { view: link.view, views: link.views,
      layout: link.layout ?? (this.views.layout === "heading" ? null
        : this.views.layout),
      hud: pressed("instruments") ? null : false,
      panel: pressed("controls") ? null : false,
      plan: pressed("large") ? true : null,
      theme: chosenTheme() === "system" ? link.theme : chosenTheme() };
  }

  async copy(wishes) {
    const address = write(wishes);
    this.address.hidden = false;
    this.address.textContent = address;
    try {
      await navigator.clipboard.writeText(address);
      this.say("Copied.");
    } catch {
      this.say("Copy it from here:"); // no clipboard without https
    }
  }

  show(state) {
    const views = state.views ?? [];
    const key = JSON.stringify([views.map((view) => view.name),
      this.views.name]);
    const at = this.rows.contains(document.activeElement)
      ? document.activeElement : null;
    const editing = at?.matches("input") && at.value !== at.dataset.sent;
    if (key === this.key || editing) {
      return;
    }
    this.key = key;
    const focused = at?.matches("input") ? `name ${at.value}`
      : at?.dataset.key;
    this.rows.replaceChildren(...views.map((view, i) =>
      this.row(view, i, views.length)));
    if (focused) {
      this.rows.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
    }
  }

  row(view, i, count) {
    const node = element("li", view.name === this.views.name ? "chosen" : "");
    const name = element("input", "text");
    name.value = view.name;
    name.setAttribute("aria-label", `Name of view ${view.name}`);
    name.dataset.key = `name ${view.name}`;
    name.dataset.sent = view.name;
    name.readOnly = !may("views");
    name.addEventListener("focus", () => this.views.choose(view.name));
    name.addEventListener("change", () => {
      name.dataset.sent = name.value;
      this.rename(view.name, name.value.trim());
    });
    name.addEventListener("blur", () => {
      const { views = [] } = this.store.state;
      if (!views.some((one) => one.name === name.value)) {
        name.value = name.dataset.sent = view.name; // it was refused
      }
    });
    const row = element("span", "pair");
    const small = (text, label, act, disabled = false) => {
      const made = button(row, text, `${label} ${view.name}`, act, "views");
      made.disabled = disabled;
      made.dataset.key = `${label} ${view.name}`;
      return made;
    };
    small("↑", "Earlier:", () => this.move(view.name, -1), i === 0);
    small("↓", "Later:", () => this.move(view.name, 1), i === count - 1);
    const gone = small("×", "Remove", () => this.remove(view.name, gone));
    node.append(name, row);
    return node;
  }
}
