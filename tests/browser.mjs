// Debian's Chromium, driven by Playwright.
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

import { ROOT } from "./pelagos_daemon.mjs";

const BROWSER = "/usr/bin/chromium";
const need = createRequire(path.join(ROOT, "build/npm/node_modules/"));

// A package of build/npm. Where one, or the browser, is not there: says so
// and ends with 77, as tests do that cannot run here.
export function wanted(name) {
  try {
    fs.accessSync(BROWSER);
    return need(name);
  } catch (error) {
    console.log(`no browser to test with: ${error.message.split("\n")[0]}`);
    return process.exit(77);
  }
}

export const openBrowser = () => wanted("playwright-core").chromium.launch({
  executablePath: BROWSER, args: ["--no-sandbox", "--disable-gpu",
    "--disable-quic", "--disable-dev-shm-usage",
    "--disable-background-networking", "--disable-component-update"] });
