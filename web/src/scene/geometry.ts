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
import { arrow, axes } from "./shapes.ts";

/** A particle filter has thousands of poses. */
const MAX_POSES = 5000;
/** A path of an hour at 20 Hz. */
const MAX_PATH_POINTS = 100_000;
/** The points of the trail of an odometry, one for each 2 cm. */
const MAX_TRAIL = 2000;
/** A texture of this many cells takes 64 MB, the most that a phone has room for. */
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

/** geometry_msgs/PoseArray: an arrow for each pose. */
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
    let finite = 0;
    for (let i = 0; i < count; i++) {
      const { x, y, z } = (poses[i] as { pose: Pose }).pose.position;
      if (Number.isFinite(x + y + z)) points.set([x, y, z], finite++ * 3);
    }
    this.path.set(points, finite);
  }
}

/** nav_msgs/Odometry: an arrow at the pose, and its path. */
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
    this.pointer.visible = Number.isFinite(position.x + position.y + position.z);
    if (!this.pointer.visible) return;
    setPose(this.pointer, position, orientation);
    const at = this.count * 3;
    const [x = 0, y = 0, z = 0] = this.points.subarray(at - 3, at);
    if (this.count > 0 && Math.hypot(position.x - x, position.y - y, position.z - z) < 0.02) return;
    if (this.count === MAX_TRAIL) {
      this.points.copyWithin(0, 3);
      this.count--;
    }
    this.points.set([position.x, position.y, position.z], this.count * 3);
    this.count++;
    this.trail.set(this.points, this.count);
  }
}

/** Free cells light, occupied ones dark, unknown ones gray-green as in RViz; red, green, blue and alpha of each. */
const CELL_COLORS = new Uint32Array(
  Uint8Array.from({ length: 256 * 4 }, (_, at) => {
    const [cell, channel] = [at >> 2, at & 3];
    if (channel === 3) return 255;
    return cell <= 100 ? 205 - 1.8 * cell : ([105, 120, 110][channel] as number);
  }).buffer,
);
/** The side of a texture that every graphics card supports. */
const MAX_SIDE = 4096;

/** nav_msgs/OccupancyGrid. */
export class GridDisplay extends HeaderDisplay<OccupancyGrid> {
  private readonly holder = new Group();
  private plane: Mesh<PlaneGeometry, MeshBasicMaterial> | undefined;
  private texture: DataTexture | undefined;

  constructor(context: DisplayContext) {
    super(context);
    this.group.add(this.holder);
  }

  protected draw({ info, data }: OccupancyGrid): void {
    const { width, height, resolution, origin } = info;
    const problem = problemOfMap(width, height, data.length);
    this.context.report(problem);
    this.holder.visible = problem === "";
    if (problem !== "") return;
    const plane = this.paint(data, width, height);
    // The origin is the pose of the cell (0, 0); a plane's own origin is its middle.
    plane.scale.set(width * resolution, height * resolution, 1);
    plane.position.set((width * resolution) / 2, (height * resolution) / 2, -0.002);
    setPose(this.holder, origin.position, origin.orientation);
  }

  /** The plane of one meter with the cells on it; maps that grow need a new texture. */
  private paint(cells: Int8Array, width: number, height: number): Mesh {
    const step = Math.ceil(Math.max(width, height) / MAX_SIDE);
    const [columns, rows] = [Math.ceil(width / step), Math.ceil(height / step)];
    const { image } = this.texture ?? {};
    if (this.texture === undefined || image?.width !== columns || image?.height !== rows) {
      this.texture?.dispose();
      this.texture = new DataTexture(new Uint8Array(columns * rows * 4), columns, rows);
      this.texture.magFilter = NearestFilter;
      this.texture.colorSpace = SRGBColorSpace;
    }
    const pixels = new Uint32Array((this.texture.image.data as Uint8Array).buffer);
    if (step === 1)
      for (let i = 0; i < pixels.length; i++) pixels[i] = CELL_COLORS[(cells[i] as number) & 255] as number;
    else
      for (let y = 0; y < rows; y++)
        for (let x = 0; x < columns; x++)
          pixels[y * columns + x] = CELL_COLORS[
            highestCell(cells, width, x * step, y * step, step) & 255
          ] as number;
    this.texture.needsUpdate = true;
    if (this.plane === undefined) {
      const material = new MeshBasicMaterial({ map: this.texture, side: DoubleSide });
      this.plane = new Mesh(new PlaneGeometry(1, 1), material);
      this.holder.add(this.plane);
    }
    this.plane.material.map = this.texture;
    return this.plane;
  }
}

/** The most occupied cell of a square, so that thin walls stay. */
function highestCell(cells: Int8Array, width: number, left: number, bottom: number, step: number): number {
  const top = Math.min(bottom + step, cells.length / width);
  const right = Math.min(left + step, width);
  let highest = -128;
  for (let y = bottom; y < top; y++)
    for (let x = left; x < right; x++) {
      const cell = cells[y * width + x] as number;
      if (cell > highest) highest = cell;
    }
  return highest;
}

/** Why a map cannot be drawn; empty if it can. */
function problemOfMap(width: number, height: number, cellCount: number): string {
  const size = `${width} x ${height} cells`;
  if (width * height > MAX_CELLS) return `A map of ${size} is too large for the page.`;
  if (width * height !== cellCount) return `This map should have ${size}, but has ${cellCount}.`;
  return cellCount === 0 ? "This map is empty." : "";
}
