// The path of a robot as positions on the earth; old positions are thinned out, so that hours fit.
export interface Position {
  readonly latitude: number;
  readonly longitude: number;
}

/** The distance between points of the track; GPS is less accurate. */
const STEP_M = 0.5;
// Drawing more takes too long.
const MAX_POINTS = 20_000;
const EARTH_RADIUS_M = 6_371_000;

/** Meters between two positions near each other. */
export function distanceM(a: Position, b: Position): number {
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
  readonly positions: Position[] = [];

  /** Returns whether the track grew. */
  add(position: Position): boolean {
    const last = this.positions.at(-1);
    if (last !== undefined && distanceM(last, position) < STEP_M) return false;
    this.positions.push(position);
    // Every other older point is dropped: the shape stays, and there is room for new points.
    if (this.positions.length > MAX_POINTS) {
      const kept = this.positions.filter((_, i) => i % 2 === 0 || i > MAX_POINTS * 0.9);
      this.positions.splice(0, this.positions.length, ...kept);
    }
    return true;
  }
}
