// The distance from which a camera shows a whole box.
import { type Box3, Vector3 } from "three";

/** The part of the picture's width and height that the box fills. */
const FILLED = 0.8;

/**
 * The distance from the box's middle, seen from direction `toCamera` with z up, in the unit of the box.
 *
 * `halfAngle` is half of the vertical field of view in radians, `aspect` the picture's width by its height.
 */
export function distanceToFit(box: Box3, toCamera: Vector3, halfAngle: number, aspect: number): number {
  const back = toCamera.clone().normalize();
  const right = new Vector3(0, 0, 1).cross(back).normalize();
  const up = back.clone().cross(right);
  const tanUp = Math.tan(halfAngle) * FILLED;
  const half = box.getSize(new Vector3()).multiplyScalar(0.5);
  let distance = 0;
  for (const x of [-half.x, half.x])
    for (const y of [-half.y, half.y])
      for (const z of [-half.z, half.z]) {
        const corner = new Vector3(x, y, z);
        const needed = Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / aspect) / tanUp;
        distance = Math.max(distance, needed + corner.dot(back));
      }
  return distance;
}
