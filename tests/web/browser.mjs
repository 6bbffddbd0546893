// Drives one page in Chromium. Commands are JSON lines on the standard input, answers JSON lines on the output.
// Usage: node browser.mjs FOLDER_WITH_NODE_MODULES CHROMIUM
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const [, , packages, executablePath] = process.argv;
const { chromium } = createRequire(`${packages}/x.js`)("playwright-core");
const browser = await chromium.launch({
  executablePath,
  args: [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    // Only WebGL is drawn by the simulated graphics card, which takes twice as long for the rest of a page.
    "--disable-gpu-compositing",
    "--js-flags=--expose-gc",
    "--use-fake-device-for-media-stream",
  ],
});
const pages = [];
const seen = [];
const frozen = {};

async function open({ url, width = 1280, height = 800, touch = false, script, ...options }) {
  const context = await browser.newContext({
    viewport: { width, height },
    hasTouch: touch,
    isMobile: touch,
    ...options,
  });
  await context.addInitScript(() => {
    const next = globalThis.requestAnimationFrame.bind(globalThis);
    globalThis.requestAnimationFrame = (draw) => setTimeout(() => next(draw), 60);
    globalThis.cancelAnimationFrame = clearTimeout;
  });
  if (script) await context.addInitScript(script);
  const page = await context.newPage();
  const hosts = new Set();
  const errors = [];
  page.on("request", (request) => hosts.add(new URL(request.url()).host));
  page.on("websocket", (socket) => hosts.add(new URL(socket.url()).host));
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => {
    // A server that is away is what some tests are about.
    if (message.type() === "error" && !/WebSocket|ERR_CONNECTION/.test(message.text())) errors.push(message.text());
  });
  await page.goto(url);
  seen.push({ hosts, errors });
  return pages.push(page) - 1;
}

const commands = {
  open,
  evaluate: ({ page, script }) => pages[page].evaluate(script),
  click: ({ page, selector }) => pages[page].click(selector, { timeout: 30_000 }),
  fill: ({ page, selector, text }) => pages[page].fill(selector, text, { timeout: 30_000 }).then(() => null),
  download: async ({ page, selector, path }) => {
    const [saved] = await Promise.all([
      pages[page].waitForEvent("download", { timeout: 30_000 }),
      pages[page].click(selector, { timeout: 30_000 }),
    ]);
    await saved.saveAs(path);
    return null;
  },
  text: ({ page, selector }) => pages[page].textContent(selector, { timeout: 30_000 }),
  // As when another tab is chosen.
  hide: ({ page, hidden }) =>
    pages[page].evaluate((isHidden) => {
      Object.defineProperty(document, "hidden", { get: () => isHidden, configurable: true });
      document.dispatchEvent(new Event("visibilitychange"));
    }, hidden),
  // Stops the page's scripts, as a phone does with a page that it puts to sleep.
  freeze: async ({ page }) => {
    frozen[page] = await pages[page].context().newCDPSession(pages[page]);
    await frozen[page].send("Debugger.enable");
    await frozen[page].send("Debugger.pause");
    return null;
  },
  thaw: async ({ page }) => {
    await frozen[page].detach();
    return null;
  },
  // A phone that lies on a table and turns.
  sense: async ({ page, readings }) => {
    const session = await pages[page].context().newCDPSession(pages[page]);
    for (const [type, reading] of Object.entries(readings)) {
      await session.send("Emulation.setSensorOverrideEnabled", { enabled: true, type });
      await session.send("Emulation.setSensorOverrideReadings", { type, reading });
    }
    return null;
  },
  screenshot: ({ page, path }) => pages[page].screenshot({ path }).then(() => null),
  memory: async ({ page }) => {
    const session = await pages[page].context().newCDPSession(pages[page]);
    await session.send("HeapProfiler.collectGarbage");
    const { usedSize } = await session.send("Runtime.getHeapUsage");
    const { nodes, jsEventListeners } = await session.send("Memory.getDOMCounters");
    await session.detach();
    return { bytes: usedSize, nodes, listeners: jsEventListeners };
  },
  reload: ({ page }) => pages[page].reload().then(() => null),
  close: ({ page }) => pages[page].context().close(),
  seen: ({ page }) => ({ hosts: [...seen[page].hosts], errors: seen[page].errors }),
  closeAll: () => Promise.all(browser.contexts().map((each) => each.close())).then(() => null),
};

for await (const line of createInterface({ input: process.stdin })) {
  const { id, command, ...given } = JSON.parse(line);
  let answer;
  try {
    answer = { id, result: (await commands[command](given)) ?? null };
  } catch (error) {
    answer = { id, error: String(error) };
  }
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
await browser.close();
