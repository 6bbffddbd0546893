// Takes the pictures of the documentation from a running dashboard: node screenshots.mjs URL FOLDER
import { chromium } from "playwright-core";

const [url, folder] = process.argv.slice(2);
const WIDE = { width: 1280, height: 800 };
const PHONE = { width: 390, height: 740 };
// 3D takes longest: its code is loaded on first use, and drawn by software here.
const SETTLE_MS = 4000;
const PICTURES = [
  { name: "dashboard", panel: "", size: WIDE, scheme: "light" },
  { name: "dashboard-phone", panel: "", size: PHONE, scheme: "light" },
  { name: "dashboard-boards", panel: "boards", size: WIDE, scheme: "light" },
  { name: "dashboard-plots", panel: "plots", size: WIDE, scheme: "dark" },
  { name: "dashboard-scene", panel: "scene", size: WIDE, scheme: "dark" },
  { name: "dashboard-topics", panel: "topics", size: WIDE, scheme: "light" },
  { name: "dashboard-controls-phone", panel: "controls", size: PHONE, scheme: "dark" },
];

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
for (const { name, panel, size, scheme } of PICTURES) {
  const context = await browser.newContext({ viewport: size, colorScheme: scheme, hasTouch: size === PHONE });
  const page = await context.newPage();
  await page.goto(`${url}/#/${panel}`);
  await page.waitForTimeout(SETTLE_MS);
  await page.screenshot({ path: `${folder}/${name}.png` });
  console.log(`${name}.png`);
  await context.close();
}
await browser.close();
