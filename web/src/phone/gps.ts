// The position as sensor_msgs/NavSatFix. Source: https://www.w3.org/TR/geolocation/
import { pageTimeMs } from "./clock_offset.ts";
import { type Problem, type Sensor, SensorError } from "./sensor.ts";

const PROBLEMS: Record<number, Problem> = { 1: "denied", 2: "unavailable", 3: "unavailable" };
const STATUS_FIX = 0;
const SERVICE_GPS = 1;
const APPROXIMATED = 1;
const RETRY_MS = 500;
// Accuracies are of 95 %, covariances of one standard deviation.
const DEVIATIONS = 1.96;

export const gps: Sensor = {
  id: "gps",
  type: "sensor_msgs/NavSatFix",
  topic: "fix",
  start(output) {
    if (!("geolocation" in navigator)) return Promise.reject(new SensorError("missing"));
    return new Promise((resolve, reject) => {
      let isStarted = false;
      // A phone that does not move has one position for long: it is kept until there is a connection.
      let unsent: (() => boolean) | undefined;
      const send = () => {
        if (unsent?.()) unsent = undefined;
      };
      const timer = setInterval(send, RETRY_MS);
      const end = () => {
        clearInterval(timer);
        navigator.geolocation.clearWatch(id);
      };
      const started = () => {
        if (isStarted) return;
        isStarted = true;
        resolve(end);
      };
      const id = navigator.geolocation.watchPosition(
        ({ coords, timestamp }) => {
          started();
          const { accuracy, altitude, altitudeAccuracy } = coords;
          const level = (accuracy / DEVIATIONS) ** 2;
          const height = altitudeAccuracy == null ? level * 4 : (altitudeAccuracy / DEVIATIONS) ** 2;
          // By how long ago it was: the wall clock may have been set since the page was opened.
          const measuredMs = pageTimeMs() - Math.max(0, Date.now() - timestamp);
          const fix = {
            status: { status: STATUS_FIX, service: SERVICE_GPS },
            latitude: coords.latitude,
            longitude: coords.longitude,
            altitude: altitude ?? Number.NaN,
            position_covariance: [level, 0, 0, 0, level, 0, 0, 0, height],
            position_covariance_type: APPROXIMATED,
          };
          unsent = () => output.publish(fix, measuredMs);
          send();
        },
        ({ code }) => {
          const problem = PROBLEMS[code] ?? "unavailable";
          if (isStarted && problem !== "denied") return;
          if (isStarted) output.fail(problem);
          else {
            end();
            reject(new SensorError(problem));
          }
        },
        { enableHighAccuracy: true },
      );
    });
  },
};
