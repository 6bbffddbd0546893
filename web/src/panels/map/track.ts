// The path of a robot, as positions on the earth, thinned so that hours fit.
export interface Place {
  readonly latitude: number;
  readonly longitude: number;
}

/** Meters between points of the track; GPS is no more accurate. */
const STEP_M = 0.5;
const MAX_POINTS = 20_000;
const EARTH_RADIUS_M = 6_371_000;

/** Meters between two places near each other. */
export function distanceM(a: Place, b: Place): number {
  const radians = Math.PI / 180;
  const north = (b.latitude - a.latitude) * radians;
  const east = (b.longitude - a.longitude) * radians * Math.cos(a.latitude * radians);
  return EARTH_RADIUS_M * Math.hypot(north, east);
}

/** The longitude that is nearest to another: beyond 180 degrees for a robot that crosses the date line. */
export function nearestLongitude(longitude: number, to: number): number {
  return longitude + 360 * Math.round((to - longitude) / 360);
}

export class Track {
  readonly places: Place[] = [];

  /** Returns whether the track grew. */
  add(place: Place): boolean {
    const last = this.places.at(-1);
    if (last !== undefined && distanceM(last, place) < STEP_M) return false;
    this.places.push(place);
    // Keeps every other older point: the shape stays, and there is room for new points.
    if (this.places.length > MAX_POINTS) {
      const kept = this.places.filter((_, i) => i % 2 === 0 || i > MAX_POINTS * 0.9);
      this.places.splice(0, this.places.length, ...kept);
    }
    return true;
  }
}
