#!/usr/bin/env node
// /v1/openapi.json as others read it: Redocly's linter; a client of each of two
// generators, openapi-typescript's types, by which TypeScript checks a program of
// openapi-fetch and its calls, and openapi-typescript-codegen's, which has to
// compile as it is.
//
// Skipped (77) without these packages.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { after, before, describe, test } from "node:test";
import { pathToFileURL } from "node:url";

import { Daemon, folder, ROOT } from "./pelagos_daemon.mjs";

const NPM = path.join(ROOT, "build/npm/node_modules");
const CODEGEN = "openapi-typescript-codegen";
for (const name of ["openapi-typescript", "openapi-fetch", "typescript",
  CODEGEN]) {
  if (!fs.existsSync(path.join(NPM, name))) {
    console.log(`no ${name}: make deps`);
    process.exit(77);
  }
}

const PROGRAM = `
import createClient from "openapi-fetch";
import type { components, paths } from "./pelagos.js";

export async function calls(baseUrl: string) {
  const client = createClient<paths>({ baseUrl });
  const health = await client.GET("/healthz");
  const set = await client.PATCH("/v1/state", {
    body: { sea: { windSpeed: 7.5, spectrum: "JONSWAP" },
      views: { bridge: { yaw: 12 } } },
  });
  const wind: number | undefined = set.data?.sea?.windSpeed;
  const refused = await client.PATCH("/v1/state", {
    body: { sea: { windSpeed: 99 } },
  });
  const problem: components["schemas"]["Problem"] | undefined = refused.error;
  const surface = await client.POST("/v1/surface", {
    body: { points: [[0, 5], [25, -10]] },
  });
  const frame = await client.GET("/v1/views/{view}/frame.jpg", {
    params: { path: { view: "bridge" }, query: { width: 160, height: 90 } },
    parseAs: "arrayBuffer",
  });
  return { health: health.data, wind, problem, surface: surface.data,
    status: refused.response.status, frame: frame.data as unknown };
}

// Each of these has one mistake, which the compiler has to find.
export async function mistakes(baseUrl: string) {
  const client = createClient<paths>({ baseUrl });
  // @ts-expect-error: no such field
  await client.PATCH("/v1/state", { body: { sea: { windSped: 7.5 } } });
  // @ts-expect-error: no such spectrum
  await client.PATCH("/v1/state", { body: { sea: { spectrum: "JONSWOP" } } });
  // @ts-expect-error: a number
  await client.PATCH("/v1/state", { body: { sea: { windSpeed: "12" } } });
  // @ts-expect-error: no such path
  await client.POST("/v1/surfaces", { body: { points: [[0, 5]] } });
  await client.GET("/v1/views/{view}/frame.jpg", {
    // @ts-expect-error: no such parameter
    params: { path: { view: "bridge" }, query: { wide: 160 } } });
}
`;
const COMPILER = { compilerOptions: { strict: true, target: "es2022",
  module: "nodenext", moduleResolution: "nodenext", lib: ["es2022", "dom"],
  types: [], skipLibCheck: true, outDir: "out" }, files: ["client.ts"] };

describe("a generated client", () => {
  const work = folder();
  let daemon;

  function run(...args) {
    const said = spawnSync(process.execPath, args, { cwd: work,
      encoding: "utf8" });
    return { status: said.status, text: said.stdout + said.stderr };
  }

  function compile(program) {
    fs.writeFileSync(path.join(work, "client.ts"), program);
    return run(path.join(NPM, "typescript/bin/tsc"));
  }

  before(async () => {
    daemon = await Daemon.start();
    const answer = await fetch(`${daemon.url}/v1/openapi.json`);
    fs.writeFileSync(path.join(work, "openapi.json"), await answer.text());
    fs.symlinkSync(NPM, path.join(work, "node_modules"));
    fs.writeFileSync(path.join(work, "package.json"), '{"type": "module"}');
    fs.writeFileSync(path.join(work, "tsconfig.json"),
      JSON.stringify(COMPILER));
    const made = run(path.join(NPM, "openapi-typescript/bin/cli.js"),
      // What has a default may be left out of a request.
      "openapi.json", "-o", "pelagos.ts", "--default-non-nullable=false");
    assert.equal(made.status, 0, made.text);
  });

  after(async () => {
    await daemon.stop();
    fs.rmSync(work, { recursive: true });
  });

  test("the document has no fault that Redocly's linter finds", async () => {
    const { createConfig, lint } = createRequire(path.join(NPM, "x.js"))(
      "@redocly/openapi-core");
    const config = await createConfig({ extends: ["recommended"] });
    const judge = async (document) => {
      const ref = path.join(work, "judged.json");
      fs.writeFileSync(ref, JSON.stringify(document));
      return (await lint({ ref, config })).map(({ ruleId, message }) =>
        `${ruleId}: ${message}`);
    };
    const document = JSON.parse(fs.readFileSync(
      path.join(work, "openapi.json"), "utf8"));
    assert.deepEqual(await judge(document), []);
    const { parameters } = document.paths["/v1/spectrum"].get;
    parameters.push(parameters[0]);
    assert.match((await judge(document)).join(), /operation-parameters-unique/);
  });

  test("every array says what is in it", () => {
    const walk = (value, at) => {
      if (value?.type === "array") {
        assert.ok("items" in value, at);
      }
      for (const [key, inner] of Object.entries(value ?? {})) {
        if (typeof inner === "object") {
          walk(inner, `${at}/${key}`);
        }
      }
    };
    walk(JSON.parse(fs.readFileSync(path.join(work, "openapi.json"), "utf8")),
      "");
  });

  test("by another generator it compiles as well", () => {
    const made = run(path.join(NPM, CODEGEN, "bin/index.js"), "--input",
      "openapi.json", "--output", "other");
    assert.equal(made.status, 0, made.text);
    fs.writeFileSync(path.join(work, "other.json"), JSON.stringify({
      compilerOptions: { strict: true, target: "es2022", module: "esnext",
        moduleResolution: "bundler", lib: ["es2022", "dom", "dom.iterable"],
        types: [], skipLibCheck: true, noEmit: true },
      files: ["other/index.ts"] }));
    const said = run(path.join(NPM, "typescript/bin/tsc"), "-p", "other.json");
    assert.equal(said.status, 0, said.text);
  });

  test("knows the fields, and no others", () => {
    const said = compile(PROGRAM);
    assert.equal(said.status, 0, said.text);
  });

  test("calls the daemon", async () => {
    assert.equal(compile(PROGRAM).status, 0);
    const client = await import(
      pathToFileURL(path.join(work, "out/client.js")).href);
    const said = await client.calls(daemon.url);
    assert.equal(said.health.status, "ok");
    assert.equal(said.wind, 7.5);
    assert.equal(said.status, 400);
    assert.equal(said.problem.path, "sea.windSpeed");
    assert.equal(said.problem.maximum, 30);
    const state = await (await fetch(`${daemon.url}/v1/state`)).json();
    assert.equal(state.sea.windSpeed, 7.5);
    assert.equal(state.views.find((v) => v.name === "bridge").yaw, 12);
    assert.equal(said.surface.points?.length ?? said.surface.height?.length, 2,
      JSON.stringify(said.surface));
    const jpeg = new Uint8Array(said.frame);
    assert.deepEqual([...jpeg.subarray(0, 3)], [0xff, 0xd8, 0xff]);
  });
});
