import assert from "node:assert/strict";
import { test } from "node:test";
import {
  Box3,
  type BufferGeometry,
  Color,
  type DataTexture,
  type Line,
  type Mesh,
  type MeshBasicMaterial,
  type Object3D,
} from "three";
import { expandByContent } from "../src/scene/content_bounds.ts";
import type { Display } from "../src/scene/display.ts";
import type { DisplayType } from "../src/scene/display_types.ts";
import { DISPLAYS } from "../src/scene/displays.ts";

const header = { stamp: { sec: 0, nsec: 0 }, frame_id: "map" };
const pose = { position: { x: 0, y: 0, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
const XYZ = ["x", "y", "z"].map((name, i) => ({ name, offset: i * 4, datatype: 7, count: 1 }));

function show(
  type: DisplayType,
  invalidate = () => {},
): { display: Display; reports: string[]; objects: () => Object3D[] } {
  const reports: string[] = [];
  const display = DISPLAYS[type]({
    color: "#fff",
    report: (problem) => void reports.push(problem),
    invalidate,
    fetchAsset: () => Promise.reject(new Error("no files")),
  });
  const objects = () => {
    const found: Object3D[] = [];
    for (const { object } of display.placed()) object.traverse((each) => void found.push(each));
    return found;
  };
  return { display, reports, objects };
}

function cloud(fields: typeof XYZ, width: number, data: Uint8Array) {
  const point_step = data.length / Math.max(width, 1);
  return { header, height: 1, width, fields, is_bigendian: false, point_step, row_step: data.length, data };
}

test("an empty point cloud has no points and no fault", () => {
  const { display, reports, objects } = show("sensor_msgs/PointCloud2");
  const drawn = () => (objects()[1] as Mesh<BufferGeometry>).geometry.drawRange.count;
  const rgb = { name: "rgb", offset: 12, datatype: 7, count: 1 };
  const bytes = new Uint8Array(32);
  bytes.set([0, 0, 128, 0], 12);
  display.update(cloud([...XYZ, rgb], 2, bytes));
  assert.equal(drawn(), 2);
  const colors = (objects()[1] as Mesh<BufferGeometry>).geometry.getAttribute("color");
  // On a screen this is 128 again.
  assert.ok(Math.abs(new Color(colors.getX(0), 0, 0).convertLinearToSRGB().r * 255 - 128) < 0.5);
  display.update(cloud([], 0, new Uint8Array(0)));
  assert.equal(drawn(), 0);
  display.update(cloud(XYZ.slice(1), 1, new Uint8Array(16)));
  assert.equal(drawn(), 0);
  assert.deepEqual(reports.map(Boolean), [false, false, true]);
});

test("the picture shows an obstacle in range; without one, how far the sensor sees", () => {
  const { display, objects } = show("sensor_msgs/Range");
  const reach = (range: number) => {
    display.update({ header, radiation_type: 0, field_of_view: 0.3, min_range: 0.02, max_range: 4, range });
    const box = new Box3();
    expandByContent(box, objects()[0]!);
    return box.max.x;
  };
  assert.ok(Math.abs(reach(1) - 1) < 0.01);
  assert.ok(Math.abs(reach(Number.POSITIVE_INFINITY) - 4) < 0.01);
});

test("markers with numbers that are not finite are named and not drawn", () => {
  const { display, reports, objects } = show("visualization_msgs/MarkerArray");
  const one = { x: 1, y: 1, z: 1 };
  const marker = {
    ...{ header, ns: "a", id: 1, type: 4, action: 0, pose, scale: one, color: { r: 1, g: 0.5, b: 0, a: 1 } },
    ...{ lifetime: header.stamp, frame_locked: false, points: [one, one], colors: [], text: "" },
  };
  display.update({ markers: [marker] });
  assert.equal(objects().length, 3);
  const { material } = objects()[2] as Mesh<BufferGeometry, MeshBasicMaterial>;
  assert.equal(material.color.getHexString(), "ff8000");
  display.update({ markers: [{ ...marker, points: [one, { ...one, x: Number.NaN }] }] });
  assert.equal(objects().length, 0);
  assert.match(reports.at(-1) as string, /a\/1/);
});

test("a map wider than the largest picture keeps its walls, and its picture is reused", () => {
  const { display, reports, objects } = show("nav_msgs/OccupancyGrid");
  const [width, height] = [10_001, 4];
  const data = new Int8Array(width * height).fill(-1);
  data[7] = 100;
  const map = { header, info: { resolution: 0.1, width, height, origin: pose }, data };
  display.update(map);
  const plane = objects()[2] as Mesh<BufferGeometry, MeshBasicMaterial>;
  const texture = plane.material.map as DataTexture;
  const { image } = texture;
  assert.deepEqual([image.width, image.height], [3334, 2]);
  assert.deepEqual(
    [...(image.data as Uint8Array).subarray(0, 16)].filter((_, at) => at % 4 !== 3),
    [...[105, 120, 110, 105, 120, 110, 25, 25, 25, 105, 120, 110]],
  );
  assert.ok(Math.abs(plane.scale.x - 1000.1) < 1e-9);
  display.update({ ...map, data: data.fill(0) });
  assert.equal(plane.material.map, texture);
  assert.equal((image.data as Uint8Array)[0], 205);
  display.update({ ...map, data: new Int8Array(3) });
  assert.equal((objects()[1] as Object3D).visible, false);
  assert.match(reports.at(-1)!, /should have 10001 x 4 cells, but has 3/);
  display.update({ ...map, info: { ...map.info, width: 0, height: 0 }, data: new Int8Array(0) });
  assert.equal(reports.at(-1), "This map is empty.");
});

test("a marker that expires changes the picture by itself", async () => {
  let onChange = () => {};
  const changed = new Promise<void>((resolve) => {
    onChange = resolve;
  });
  const { display, objects } = show("visualization_msgs/Marker", onChange);
  const sizes = { scale: { x: 1, y: 1, z: 1 }, color: { r: 1, g: 0, b: 0, a: 1 } };
  const lifetime = { sec: 0, nsec: 20_000_000 };
  display.update({
    header,
    ns: "",
    id: 0,
    type: 1,
    action: 0,
    pose,
    ...sizes,
    lifetime,
    points: [],
    colors: [],
  });
  assert.ok(objects().length > 0);
  await changed;
  assert.deepEqual(objects(), []);
});

test("the trail of an odometry has a point for each 2 cm, even upwards", () => {
  const { display, objects } = show("nav_msgs/Odometry");
  for (const z of [0, 0.01, 0.03, 0.06])
    display.update({ header, pose: { pose: { ...pose, position: { x: 0, y: 0, z } } } });
  const line = objects().find((each) => each.type === "Line") as Line;
  assert.equal(line.geometry.drawRange.count, 3);
});
