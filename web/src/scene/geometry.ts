// Displays of geometry_msgs and nav_msgs: poses, paths, odometry and maps.
import {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  PlaneGeometry,
  SRGBColorSpace,
} from "three";
import { type DisplayContext, HeaderDisplay, setPose } from "./display.ts";
import type { OccupancyGrid, Pose } from "./messages.ts";
import { arrow, axes, emptyGroup } from "./shapes.ts";

/** A particle filter has some thousands of poses. */
const MAX_POSES = 5000;
/** A path of an hour at 20 Hz. */
const MAX_PATH_POINTS = 100_000;
/** Odometry leaves a trail of so many points, one for each 2 cm of way. */
const MAX_TRAIL = 2000;
/** 64 million cells are 64 MB of texture, more than a phone gives. */
const MAX_CELLS = 4096 * 4096;

/** A line through points, replaced as a whole. */
class Polyline {
  readonly line: Line;
  private readonly geometry = new BufferGeometry();

  constructor(color: string) {
    this.line = new Line(this.geometry, new LineBasicMaterial({ color }));
    this.line.frustumCulled = false;
  }

  set(points: Float32Array, count: number): void {
    const have = this.geometry.getAttribute("position") as BufferAttribute | undefined;
    if (have === undefined || have.count < count) {
      const room = new BufferAttribute(new Float32Array(Math.ceil(count * 1.25) * 3), 3);
      this.geometry.setAttribute("position", room);
    }
    const position = this.geometry.getAttribute("position") as BufferAttribute;
    (position.array as Float32Array).set(points.subarray(0, count * 3));
    position.needsUpdate = true;
    this.geometry.setDrawRange(0, count);
  }
}

/** geometry_msgs/PoseStamped and PoseWithCovarianceStamped: an arrow along x. */
export class PoseDisplay extends HeaderDisplay<{ pose: Pose | { pose: Pose } }> {
  private readonly pointer = new Group();

  constructor(context: DisplayContext) {
    super(context);
    this.pointer.add(arrow(0.4, context.color), axes(0.15));
    this.group.add(this.pointer);
  }

  protected draw({ pose }: { pose: Pose | { pose: Pose } }): void {
    const { position, orientation } = "pose" in pose ? pose.pose : pose;
    setPose(this.pointer, position, orientation);
  }
}

/** geometry_msgs/PoseArray: an arrow each. */
export class PoseArrayDisplay extends HeaderDisplay<{ poses: Pose[] }> {
  private readonly arrows: Group[] = [];

  protected draw({ poses }: { poses: Pose[] }): void {
    const count = Math.min(poses.length, MAX_POSES);
    while (this.arrows.length < count) {
      const next = this.arrows[0]?.clone() ?? arrow(0.2, this.context.color, 0.008);
      this.arrows.push(next);
      this.group.add(next);
    }
    this.arrows.forEach((each, i) => {
      each.visible = i < count;
      if (i >= count) return;
      const { position, orientation } = poses[i] as Pose;
      setPose(each, position, orientation);
    });
  }
}

/** nav_msgs/Path: a line. */
export class PathDisplay extends HeaderDisplay<{ poses: { pose: Pose }[] }> {
  private readonly path = new Polyline(this.context.color);

  constructor(context: DisplayContext) {
    super(context);
    this.group.add(this.path.line);
  }

  protected draw({ poses }: { poses: { pose: Pose }[] }): void {
    const count = Math.min(poses.length, MAX_PATH_POINTS);
    const points = new Float32Array(count * 3);
    for (let i = 0; i < count; i++) {
      const { x, y, z } = (poses[i] as { pose: Pose }).pose.position;
      points.set([x, y, z], i * 3);
    }
    this.path.set(points, count);
  }
}

/** nav_msgs/Odometry: an arrow at the pose, and the way it came. */
export class OdometryDisplay extends HeaderDisplay<{ pose: { pose: Pose } }> {
  private readonly pointer = new Group();
  private readonly trail = new Polyline(this.context.color);
  private readonly points = new Float32Array(MAX_TRAIL * 3);
  private count = 0;

  constructor(context: DisplayContext) {
    super(context);
    this.pointer.add(arrow(0.3, context.color), axes(0.12));
    this.group.add(this.pointer, this.trail.line);
  }

  protected draw({ pose }: { pose: { pose: Pose } }): void {
    const { position, orientation } = pose.pose;
    setPose(this.pointer, position, orientation);
    const at = this.count * 3;
    const [dx, dy] = [position.x - (this.points[at - 3] ?? 0), position.y - (this.points[at - 2] ?? 0)];
    if (this.count > 0 && Math.hypot(dx, dy) < 0.02) return;
    if (this.count === MAX_TRAIL) {
      this.points.copyWithin(0, 3);
      this.count--;
    }
    this.points.set([position.x, position.y, position.z], this.count * 3);
    this.count++;
    this.trail.set(this.points, this.count);
  }
}

/** nav_msgs/OccupancyGrid: free cells light, occupied ones dark, unknown ones grey-green as in RViz. */
export class GridDisplay extends HeaderDisplay<OccupancyGrid> {
  protected draw({ info, data }: OccupancyGrid): void {
    const { width, height, resolution, origin } = info;
    emptyGroup(this.group);
    if (width * height !== data.length || width * height > MAX_CELLS || width * height === 0) {
      this.context.report(
        width * height > MAX_CELLS
          ? `A map of ${width} x ${height} cells is too large for the page.`
          : `This map says ${width} x ${height} cells and has ${data.length}.`,
      );
      return;
    }
    this.context.report("");
    const pixels = new Uint8Array(width * height * 4);
    for (let i = 0; i < data.length; i++) {
      const cell = data[i] as number;
      const grey = cell < 0 || cell > 100 ? 105 : 205 - 1.8 * cell;
      pixels.set(
        [grey, cell < 0 || cell > 100 ? 120 : grey, cell < 0 || cell > 100 ? 110 : grey, 255],
        i * 4,
      );
    }
    const texture = new DataTexture(pixels, width, height);
    texture.magFilter = NearestFilter;
    texture.colorSpace = SRGBColorSpace;
    texture.needsUpdate = true;
    const plane = new Mesh(
      new PlaneGeometry(width * resolution, height * resolution),
      new MeshBasicMaterial({ map: texture, side: DoubleSide }),
    );
    // The origin is the pose of the cell (0, 0); a plane's own origin is its middle.
    plane.position.set((width * resolution) / 2, (height * resolution) / 2, -0.002);
    const placed = new Group();
    placed.add(plane);
    setPose(placed, origin.position, origin.orientation);
    this.group.add(placed);
  }
}
