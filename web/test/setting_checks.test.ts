// Links and the browser's storage may give a panel settings of any type.
import assert from "node:assert/strict";
import { test } from "node:test";
import { consolePanel } from "../src/panels/console/console.ts";
import { drivePanel } from "../src/panels/drive/drive.ts";
import { imagesPanel } from "../src/panels/images/images.ts";
import { scenePanel } from "../src/panels/scene/scene.ts";
import { validSettings } from "../src/panels/setting_checks.ts";

test("settings of the right types are kept", () => {
  const scene = { fixedFrame: "map", hidden: ["tf"] };
  assert.deepEqual(validSettings(scene, scenePanel.settings), scene);
  const images = { topic: "/c", turns: { "/c": { quarters: 1, mirrored: true } } };
  assert.deepEqual(validSettings(images, imagesPanel.settings), images);
});

test("settings of other types, and those that the panel does not have, are omitted", () => {
  const scene = {
    fixedFrame: 5,
    followedFrame: ["a"],
    hidden: "tf",
    only: [1],
    rviz: null,
    constructor: "x",
  };
  assert.deepEqual(validSettings(scene, scenePanel.settings), {});
  assert.deepEqual(validSettings({ level: "loud", search: "x" }, consolePanel.settings), { search: "x" });
  assert.deepEqual(
    validSettings({ turns: { "/c": { quarters: 0.5, mirrored: true } } }, imagesPanel.settings),
    {},
  );
  assert.deepEqual(validSettings({ search: "x" }, undefined), {});
  assert.deepEqual(validSettings(null, scenePanel.settings), {});
});

test("a link does not drive a robot faster than the sliders, or backwards", () => {
  const limits = (linear: unknown) => ({ limits: { "/cmd_vel": { linear, angular: 1 } } });
  assert.deepEqual(validSettings(limits(0.5), drivePanel.settings), limits(0.5));
  for (const each of [50, -0.3, Number.NaN, "1", undefined])
    assert.deepEqual(validSettings(limits(each), drivePanel.settings), {}, String(each));
});
