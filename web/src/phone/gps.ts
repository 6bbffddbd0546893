// The position as sensor_msgs/NavSatFix. Source: https://www.w3.org/TR/geolocation/
import { pageTimeMs } from "./clock_offset.ts";
import { type Sensor, SensorError } from "./sensor.ts";

const DENIED = 1;
const STATUS_FIX = 0;
const SERVICE_GPS = 1;
const APPROXIMATED = 1;
// A phone that does not move keeps its position for a long time; later subscribers need it too.
const REPEAT_MS = 1000;
// An accuracy is the radius of 95 % confidence, a covariance is the square of one standard deviation.
const DEVIATIONS = 1.96;

export const gps: Sensor = {
  id: "gps",
  type: "sensor_msgs/NavSatFix",
  topic: "fix",
  async start(output) {
    if (!("geolocation" in navigator)) throw new SensorError("missing");
    let publish: (() => void) | undefined;
    let timer: ReturnType<typeof setInterval> | undefined;
    const id = navigator.geolocation.watchPosition(
      ({ coords, timestamp }) => {
        const { accuracy, altitude, altitudeAccuracy } = coords;
        const level = (accuracy / DEVIATIONS) ** 2;
        const height = altitudeAccuracy == null ? level * 4 : (altitudeAccuracy / DEVIATIONS) ** 2;
        // From the age of the position: the wall clock may have been set since the page was opened.
        const measuredMs = pageTimeMs() - Math.max(0, Date.now() - timestamp);
        const fix = {
          status: { status: STATUS_FIX, service: SERVICE_GPS },
          latitude: coords.latitude,
          longitude: coords.longitude,
          altitude: altitude ?? Number.NaN,
          position_covariance: [level, 0, 0, 0, level, 0, 0, 0, height],
          position_covariance_type: APPROXIMATED,
        };
        publish = () => output.publish(fix, measuredMs);
        publish();
        clearInterval(timer);
        timer = setInterval(publish, REPEAT_MS);
      },
      // Without satellites for a while, the last position is repeated; its stamp shows its age.
      ({ code }) => {
        if (publish === undefined || code === DENIED) output.fail(code === DENIED ? "denied" : "unavailable");
      },
      { enableHighAccuracy: true },
    );
    return () => {
      clearInterval(timer);
      navigator.geolocation.clearWatch(id);
    };
  },
};
