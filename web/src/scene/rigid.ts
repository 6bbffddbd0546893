// Rigid transforms as plain numbers, so that the tf buffer needs no 3D library.
export type Vec3 = readonly [number, number, number];
/** x, y, z, w, of length 1. */
export type Quaternion = readonly [number, number, number, number];

export interface Transform {
  readonly translation: Vec3;
  readonly rotation: Quaternion;
}

export const IDENTITY: Transform = { translation: [0, 0, 0], rotation: [0, 0, 0, 1] };

/** The rotation with length 1; the identity if all values are zero, as in unset messages. */
export function normalized([x, y, z, w]: Quaternion): Quaternion {
  const length = Math.hypot(x, y, z, w);
  if (!(length > 1e-9)) return IDENTITY.rotation;
  return [x / length, y / length, z / length, w / length];
}

export function multiply(a: Quaternion, b: Quaternion): Quaternion {
  const [ax, ay, az, aw] = a;
  const [bx, by, bz, bw] = b;
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export function rotate([x, y, z, w]: Quaternion, [vx, vy, vz]: Vec3): Vec3 {
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx];
}

/** First `b`, then `a`: parent_from_child composed with child_from_grandchild. */
export function compose(a: Transform, b: Transform): Transform {
  const [x, y, z] = rotate(a.rotation, b.translation);
  const [tx, ty, tz] = a.translation;
  return { translation: [x + tx, y + ty, z + tz], rotation: multiply(a.rotation, b.rotation) };
}

export function invert({ translation, rotation }: Transform): Transform {
  const [x, y, z, w] = rotation;
  const back: Quaternion = [-x, -y, -z, w];
  const [tx, ty, tz] = rotate(back, translation);
  return { translation: [-tx, -ty, -tz], rotation: back };
}

/** The pose at `share` (0 to 1) of the way from `a` to `b`: linear, and slerp for the rotation. */
export function interpolate(a: Transform, b: Transform, share: number): Transform {
  const mix = (i: 0 | 1 | 2) => a.translation[i] + (b.translation[i] - a.translation[i]) * share;
  return { translation: [mix(0), mix(1), mix(2)], rotation: slerp(a.rotation, b.rotation, share) };
}

function slerp(a: Quaternion, b: Quaternion, share: number): Quaternion {
  let cos = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = cos < 0 ? -1 : 1;
  cos *= sign;
  let [ka, kb] = [1 - share, share];
  // Nearly equal rotations: the line between them is exact enough, and sin(angle) is near 0.
  if (cos < 0.9995) {
    const angle = Math.acos(cos);
    ka = Math.sin((1 - share) * angle) / Math.sin(angle);
    kb = Math.sin(share * angle) / Math.sin(angle);
  }
  kb *= sign;
  return normalized([
    ka * a[0] + kb * b[0],
    ka * a[1] + kb * b[1],
    ka * a[2] + kb * b[2],
    ka * a[3] + kb * b[3],
  ]);
}

/** Roll, pitch and yaw in degrees, for people. */
export function eulerDegrees([x, y, z, w]: Quaternion): Vec3 {
  const degrees = 180 / Math.PI;
  const sinPitch = Math.max(-1, Math.min(1, 2 * (w * y - z * x)));
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) * degrees,
    Math.asin(sinPitch) * degrees,
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) * degrees,
  ];
}
