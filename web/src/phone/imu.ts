// Motion and orientation as sensor_msgs/Imu, in the device's frame: x to the right of the screen, y to its top, z out of it.
// Sources: https://www.w3.org/TR/orientation-event/, REP 145.
import { pageTimeMs } from "./clock_offset.ts";
import { rateLimiter, type Sensor, SensorError } from "./sensor.ts";

const RADIANS = Math.PI / 180;
// Browsers without sensors send no event, or an event without values.
const FIRST_EVENT_MS = 3000;
const UNKNOWN = [-1, 0, 0, 0, 0, 0, 0, 0, 0];

interface Quaternion {
  x: number;
  y: number;
  z: number;
  w: number;
}

/** The attitude from the angles of a DeviceOrientationEvent in degrees: about z, then x, then y. */
export function attitude(alpha: number, beta: number, gamma: number): Quaternion {
  const [a, b, c] = [alpha, beta, gamma].map((each) => (each * RADIANS) / 2) as [number, number, number];
  const [sa, ca, sb, cb, sc, cc] = [
    Math.sin(a),
    Math.cos(a),
    Math.sin(b),
    Math.cos(b),
    Math.sin(c),
    Math.cos(c),
  ];
  return {
    x: ca * sb * cc - sa * cb * sc,
    y: ca * cb * sc + sa * sb * cc,
    z: ca * sb * sc + sa * cb * cc,
    w: ca * cb * cc - sa * sb * sc,
  };
}

/** The direction up, in the device's frame. */
function up({ x, y, z, w }: Quaternion): [number, number, number] {
  return [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}

export const imu: Sensor = {
  id: "imu",
  type: "sensor_msgs/Imu",
  topic: "imu",
  async start(output) {
    await askMotion();
    const passes = rateLimiter(output.settings.hertz);
    let orientation: Quaternion | undefined;
    let sign = 0;
    let isFound = false;
    const onOrientation = ({ alpha, beta, gamma }: DeviceOrientationEvent) => {
      if (alpha !== null && beta !== null && gamma !== null) orientation = attitude(alpha, beta, gamma);
    };
    const onMotion = (event: DeviceMotionEvent) => {
      const { accelerationIncludingGravity: force, rotationRate: rate } = event;
      if (force?.x == null || force.y == null || force.z == null) return;
      isFound = true;
      if (!passes(event.timeStamp)) return;
      // At rest, the force must point up. Safari reports the opposite sign.
      if (sign === 0 && orientation) {
        const [x, y, z] = up(orientation);
        const upward = force.x * x + force.y * y + force.z * z;
        if (Math.abs(upward) > 5) sign = Math.sign(upward);
      }
      const factor = sign || 1;
      const hasRate = rate?.alpha != null && rate.beta != null && rate.gamma != null;
      output.publish(
        {
          orientation: orientation ?? { w: 1 },
          orientation_covariance: orientation ? undefined : UNKNOWN,
          angular_velocity: hasRate
            ? { x: rate.alpha! * RADIANS, y: rate.beta! * RADIANS, z: rate.gamma! * RADIANS }
            : {},
          angular_velocity_covariance: hasRate ? undefined : UNKNOWN,
          linear_acceleration: { x: factor * force.x, y: factor * force.y, z: factor * force.z },
        },
        pageTimeMs(event.timeStamp),
      );
    };
    const kind = "ondeviceorientationabsolute" in window ? "deviceorientationabsolute" : "deviceorientation";
    addEventListener("devicemotion", onMotion);
    addEventListener(kind, onOrientation as EventListener);
    const timer = setTimeout(() => {
      if (!isFound) output.fail("missing");
    }, FIRST_EVENT_MS);
    return () => {
      clearTimeout(timer);
      removeEventListener("devicemotion", onMotion);
      removeEventListener(kind, onOrientation as EventListener);
    };
  },
};

/** Asks the user for permission if the browser requires it, as Safari does. */
async function askMotion(): Promise<void> {
  if (typeof DeviceMotionEvent === "undefined") throw new SensorError("missing");
  for (const each of [DeviceMotionEvent, DeviceOrientationEvent]) {
    const { requestPermission } = each as unknown as { requestPermission?: () => Promise<string> };
    if (requestPermission && (await requestPermission.call(each)) !== "granted")
      throw new SensorError("denied");
  }
}
