#!/usr/bin/env node
// The page keeps to the oldest browsers that it says it runs in (MINIMUM of
// clients/web/before.js): its syntax, what it calls and its style sheets, by
// MDN's tables of what each browser has had since which version.
import assert from "node:assert/strict";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { describe, it } from "node:test";

import { ROOT } from "./pelagos_daemon.mjs";

const need = createRequire(path.join(ROOT, "build/npm/node_modules/"));
let acorn, walk, css, known;
try {
  [acorn, walk, css, known] = ["acorn", "acorn-walk", "css-tree",
    "@mdn/browser-compat-data"].map((name) => need(name));
} catch (error) {
  console.log(`no tables of browsers: ${error.message.split("\n")[0]}`);
  process.exit(77);
}

const WEB = path.join(ROOT, "clients/web");
const read = (name) => fs.readFileSync(path.join(WEB, name), "utf8");
const named = (ending) => fs.readdirSync(WEB).filter((name) =>
  name.endsWith(ending)).sort();
const BEFORE = "before.js"; // runs in every browser

// Behind a question that the page asks first, or no loss where it is not there.
const ASKED = new Set([
  // pictures by WebCodecs, where VideoDecoder is (video.js, player.js)
  "VideoDecoder", "EncodedVideoChunk", "isConfigSupported", "configure",
  "displayWidth", "displayHeight",
  // else what ICE tells (peer.js)
  "connectionState",
  // else a view fills the window instead of the screen (views.js)
  "fullscreenElement", "exitFullscreen", "requestFullscreen",
  // a clock of whole pictures, where the video element tells them (played.js)
  "requestVideoFrameCallback",
]);
const STYLE_ONLY = new Set([
  // views.js gives the height where this is not known; the rose is square there
  "properties.aspect-ratio",
  // Safari's does not follow round corners before 16.4
  "properties.outline",
  // of these an older browser shows its own, or nothing is missing
  "properties.accent-color", "properties.color-scheme",
  "properties.scrollbar-width", "properties.scrollbar-color",
]);

// --- what is so new ---------------------------------------------------------------

const minimum = (() => {
  const [, table] = read(BEFORE).match(/MINIMUM = (\{[^}]*\})/);
  const { Chromium, Firefox, Safari } = Function(`return ${table}`)();
  return { chrome: Chromium, firefox: Firefox, safari: Safari };
})();

const number = (version) => {
  const [major, minor = 0] = String(version).replace("≤", "").split(".")
    .map(Number);
  return major + minor / 100;
};

// Browsers that came to have it later than the oldest; undefined: no such entry.
function lacking(entry) {
  const support = entry?.__compat?.support;
  return support && Object.entries(minimum).filter(([browser, oldest]) =>
    ![support[browser]].flat().some((one) => one && one.version_added &&
      one.version_added !== "preview" && !one.flags && !one.prefix &&
      !one.alternative_name && !one.version_removed &&
      number(one.version_added) <= number(oldest)))
    .map(([browser]) => browser);
}

// What the page has by names of its own; and every built-in object and
// interface of pages, drawing, networks, media that has a member of that name.
const own = new Set(["bytes"]); // that one in answers of the server
const owners = new Map();
const INTERFACES = new RegExp("^(Abort|Blob|Canvas|Crypto|CSS|Data|Document|" +
  "DOM|Element|Event|FormData|Headers|History|HTML|Image|KeyboardEvent|" +
  "Location|MediaQueryList|MouseEvent|Navigator|Node|Performance$|Pointer|" +
  "Promise|Readable|Request|Response|RTC|Storage|SVG|Text|UIEvent|URL|" +
  "Video|WebSocket|Wheel|Window)");
for (const [kind, table] of [["builtin", known.javascript.builtins],
  ["api", known.api]]) {
  for (const [owner, members] of Object.entries(table)) {
    for (const [name, entry] of Object.entries(members)) {
      if (name !== "__compat" && !/_(event|static)$/.test(name) &&
          (kind === "builtin" || INTERFACES.test(owner))) {
        owners.set(name, [...owners.get(name) ?? [], { kind, owner, entry }]);
      }
    }
  }
}
for (const file of named(".js").filter((name) => name !== BEFORE)) {
  try {
    walk.full(acorn.parse(read(file), { ecmaVersion: 2020,
      sourceType: "module" }), (node) => {
      const key = node.key ?? (node.type === "AssignmentExpression" &&
        node.left.property);
      if (["MethodDefinition", "Property", "AssignmentExpression"].includes(
        node.type) && key?.name) {
        own.add(key.name);
      }
    });
  } catch {
    // what does not parse is told of below
  }
}

// What before.js stands in for, as `Array.prototype.at`.
const given = new Set();
walk.simple(acorn.parse(read(BEFORE), { ecmaVersion: 5 }), {
  CallExpression({ callee, arguments: [object, name] }) {
    if (callee.name === "give") {
      given.add(name.value);
    }
  },
});

function tooNew(name, on) {
  if (given.has(name) || ASKED.has(name)) {
    return false;
  }
  const ofThat = on && (known.api[on] ?? known.javascript.builtins[on]);
  if (ofThat?.[`${name}_static`] ?? ofThat?.[name]) { // AbortSignal.timeout, Object.hasOwn
    return (lacking(ofThat[`${name}_static`] ?? ofThat[name]) ?? []).length > 0;
  }
  if (own.has(name)) {
    return false;
  }
  const found = (owners.get(name) ?? []).map(({ kind, entry }) =>
    ({ kind, lacks: lacking(entry) ?? [] }));
  // A method of lists and texts is taken for one wherever the name stands;
  // of the hundreds of interfaces one that is old enough will be meant.
  return found.some((f) => f.kind === "builtin" && f.lacks.length > 0) &&
      !found.some((f) => f.kind === "builtin" && f.lacks.length === 0) ||
    found.length > 0 && found.every((f) => f.lacks.length > 0);
}

function judge(name, text) {
  const wrong = [];
  const tree = acorn.parse(text, { ecmaVersion: 2020, sourceType: "module",
    locations: true });
  const say = (node, what) => wrong.push(`${name}:${node.loc.start.line}: ${
    what}`);
  walk.full(tree, (node) => {
    if (node.type === "MemberExpression" && !node.computed &&
        tooNew(node.property.name, node.object.name)) {
      say(node, node.property.name);
    } else if (node.type === "NewExpression" && node.callee.name &&
        !ASKED.has(node.callee.name) &&
        (lacking(known.api[node.callee.name]) ?? []).length > 0) {
      say(node, node.callee.name);
    } else if (node.type === "CallExpression" && node.callee.name &&
        (lacking(known.api[node.callee.name] ??
          known.api.Window[node.callee.name]) ?? []).length > 0) {
      say(node, node.callee.name);
    }
  });
  return wrong;
}

function judgeStyle(name, text) {
  const wrong = [];
  const tree = css.parse(text, { positions: true });
  const say = (node, what) => wrong.push(`${name}:${node.loc.start.line}: ${
    what}`);
  const old = (entry) => (lacking(entry) ?? []).length === 0;
  let unless = 0; // a rule that is one too many, where :not() holds it
  css.walk(tree, { leave(node) {
    unless -= node.name === "not" ? 1 : 0;
  }, enter(node) {
    unless += node.name === "not" ? 1 : 0;
    if (node.type === "Atrule" && !old(known.css["at-rules"][node.name])) {
      say(node, `@${node.name}`);
    } else if (node.type === "PseudoClassSelector" &&
        !old(known.css.selectors[node.name]) && !unless) {
      say(node, `:${node.name}`);
    } else if (node.type === "Declaration") {
      const key = `properties.${node.property}`;
      if (!STYLE_ONLY.has(key) && !node.property.startsWith("--") &&
          !node.property.startsWith("-") &&
          !old(known.css.properties[node.property]) &&
          !repeated(this, node)) {
        say(node, node.property);
      }
    } else if (node.type === "Function" && !["rgb", "rgba"].includes(node.name)) {
      const entry = known.css.types[node.name] ??
        known.css.types.color?.[node.name];
      if (!old(entry) && !repeated(this, node)) {
        say(node, `${node.name}()`);
      }
    } else if (node.type === "Dimension" && /^[dsl]v[hw]$/.test(node.unit) &&
        !repeated(this, node)) {
      say(node, node.unit);
    }
  } });
  return wrong;
}

// Whether the same property, or the prefixed one, stands before it, for browsers
// without this.
function repeated({ block, declaration }, node) {
  const before = block?.children.toArray() ?? [];
  const property = (declaration ?? node).property;
  return before.slice(0, before.indexOf(declaration ?? node)).some((d) =>
    d.property.replace(/^-(webkit|moz)-/, "") === property);
}

// --- the page ---------------------------------------------------------------------

describe("the page's oldest browsers", () => {
  it("parse what runs in all of them, however old", () => {
    acorn.parse(read(BEFORE), { ecmaVersion: 5 });
  });
  it("have what its modules use", () => {
    assert.deepEqual(named(".js").filter((name) => name !== BEFORE)
      .flatMap((name) => judge(name, read(name))), []);
  });
  it("have what its style sheets use", () => {
    assert.deepEqual(named(".css").flatMap((name) =>
      judgeStyle(name, read(name))), []);
  });
  it("are the ones that the manual names", () => {
    const text = fs.readFileSync(path.join(ROOT, "docs/page.md"), "utf8");
    for (const browser of ["Chromium", "Firefox", "Safari"]) {
      const [, version] = read(BEFORE).match(
        new RegExp(`${browser}: ([0-9.]+)`));
      assert.match(text, new RegExp(`${browser} ${version}\\b`));
    }
  });
});

// What it is to find, each of a kind; seen by it, or it judges nothing.
describe("the judge", () => {
  for (const text of ["const a = await b;", "a ??= 1;",
    "class A { #b() { return 1; } }", "class A { static { a(); } }"]) {
    it(`does not parse ${text}`, () => {
      assert.throws(() => judge("x", text), SyntaxError);
    });
  }
  for (const text of ["Object.hasOwn(a, b);", "Promise.any(a);",
    "a.toSorted();", "structuredClone(a);", "a.isWellFormed();",
    "crypto.randomUUID();", "new CompressionStream();",
    "AbortSignal.any([a]);", "a.checkVisibility();"]) {
    it(`finds ${text}`, () => {
      assert.notDeepEqual(judge("x", text), []);
    });
  }
  for (const text of ["a:has(b) {}", "a { text-wrap: balance }",
    "a { width: 1dvh }", "@container (width > 1px) {}", "@layer a {}",
    "a { color: color-mix(in srgb, red, blue) }", "a:is(b) {}"]) {
    it(`finds ${text}`, () => {
      assert.notDeepEqual(judgeStyle("x", text), []);
    });
  }
});
