import assert from "node:assert/strict";
import { test } from "node:test";
import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  Group,
  MathUtils,
  PerspectiveCamera,
  Points,
  Sprite,
  Vector2,
  Vector3,
} from "three";
import { distanceToFit } from "../src/scene/camera_fit.ts";
import { arrangeCaptions, type Caption } from "../src/scene/captions.ts";
import { expandByContent } from "../src/scene/content_bounds.ts";
import { cellFor } from "../src/scene/ground.ts";

const BOXES = {
  arm: new Box3(new Vector3(-0.1, -0.1, 0), new Vector3(0.1, 0.1, 0.4)),
  corridor: new Box3(new Vector3(0, -0.2, 0), new Vector3(12, 0.2, 0.3)),
};

for (const [name, box] of Object.entries(BOXES))
  for (const aspect of [2.2, 0.5])
    test(`the camera shows the whole ${name} in a picture of ${aspect}:1 and fills it`, () => {
      const camera = new PerspectiveCamera(50, aspect, 0.01, 100);
      camera.up.set(0, 0, 1);
      const toCamera = new Vector3(0.75, -0.75, 0.55).normalize();
      const center = box.getCenter(new Vector3());
      const distance = distanceToFit(box, toCamera, MathUtils.degToRad(25), aspect);
      camera.position.copy(toCamera).multiplyScalar(distance).add(center);
      camera.lookAt(center);
      camera.updateMatrixWorld();
      let farthest = 0;
      for (const x of [box.min.x, box.max.x])
        for (const y of [box.min.y, box.max.y])
          for (const z of [box.min.z, box.max.z]) {
            const seen = new Vector3(x, y, z).project(camera);
            farthest = Math.max(farthest, Math.abs(seen.x), Math.abs(seen.y));
          }
      assert.ok(Math.abs(farthest - 0.8) < 1e-6, `${farthest}`);
    });

test("a name behind the camera hides none in front of it", () => {
  const camera = new PerspectiveCamera(50, 1, 0.01, 100);
  const names = [5, -5, -7].map((z) => {
    const name = Object.assign(new Sprite(), { widthPx: 80 });
    name.position.z = z;
    return name as unknown as Caption;
  });
  arrangeCaptions(names, camera, new Vector2(400, 400));
  assert.deepEqual([names[1]?.visible, names[2]?.visible], [true, false]);
});

test("the ground's cells are 1, 2 or 5 times a power of ten", () => {
  assert.deepEqual(
    [0.3, 0.5, 1, 2.4, 26, 50].map((size) => cellFor(size)),
    [0.05, 0.1, 0.2, 0.2, 5, 10],
  );
});

test("the camera shows the drawn points, without unused buffers and outliers", () => {
  const geometry = new BufferGeometry();
  const points = new Float32Array([1, 2, 3, -4, 5, 6, Number.NaN, 0, 0, 1e6, 0, 0, 100, 100, 100]);
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setDrawRange(0, 4);
  const cloud = new Points(geometry);
  cloud.position.z = 10;
  const hidden = new Points(geometry.clone().translate(50, 0, 0));
  hidden.visible = false;
  const box = new Box3();
  expandByContent(box, new Group().add(cloud, hidden));
  assert.deepEqual([...box.min.toArray(), ...box.max.toArray()], [-4, 2, 13, 1, 5, 16]);
});
