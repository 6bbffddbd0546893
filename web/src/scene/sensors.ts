// Displays of sensor_msgs: LaserScan, Range, Imu, PointCloud2.
import {
  BoxGeometry,
  BufferGeometry,
  ConeGeometry,
  DoubleSide,
  EdgesGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Points,
  PointsMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import { LINEAR, rainbow } from "./colors.ts";
import { type DisplayContext, HeaderDisplay } from "./display.ts";
import type { Imu, LaserScan, PointCloud2, PointField, Range } from "./messages.ts";
import { normalized } from "./rigid.ts";
import { arrow, axes, resizePoints } from "./shapes.ts";

/** A message with more points is damaged; 2 million points are 48 MB of buffers. */
const MAX_POINTS = 2_000_000;

abstract class PointsDisplay<Message> extends HeaderDisplay<Message> {
  protected readonly geometry = new BufferGeometry();

  constructor(context: DisplayContext, sizePx: number) {
    super(context);
    const material = new PointsMaterial({ size: sizePx, sizeAttenuation: false, vertexColors: true });
    const points = new Points(this.geometry, material);
    points.frustumCulled = false;
    this.group.add(points);
  }
}

/** sensor_msgs/LaserScan: a point for each range within the limits, colored by intensity or distance. */
export class LaserScanDisplay extends PointsDisplay<LaserScan> {
  constructor(context: DisplayContext) {
    super(context, 3);
  }

  protected draw(scan: LaserScan): void {
    const { ranges, intensities } = scan;
    const total = Math.min(ranges.length, MAX_POINTS);
    const [positions, colors] = resizePoints(this.geometry, total);
    const bright = intensities.length === ranges.length;
    let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
    if (bright)
      for (let i = 0; i < total; i++) {
        low = Math.min(low, intensities[i] as number);
        high = Math.max(high, intensities[i] as number);
      }
    let count = 0;
    for (let i = 0; i < total; i++) {
      const range = ranges[i] as number;
      // REP 117: outside of the limits, infinite and NaN are not measurements of a distance.
      if (!(range >= scan.range_min && range <= scan.range_max)) continue;
      const angle = scan.angle_min + i * scan.angle_increment;
      positions[count * 3] = range * Math.cos(angle);
      positions[count * 3 + 1] = range * Math.sin(angle);
      positions[count * 3 + 2] = 0;
      const share =
        bright && high > low
          ? ((intensities[i] as number) - low) / (high - low)
          : 1 - range / Math.max(scan.range_max, 1e-6);
      rainbow(share, colors, count * 3);
      count++;
    }
    this.geometry.setDrawRange(0, count);
  }
}

/** sensor_msgs/Range: a cone as wide as the beam, from the sensor along x to the obstacle. */
export class RangeDisplay extends HeaderDisplay<Range> {
  private readonly material = new MeshBasicMaterial({
    color: this.context.color,
    transparent: true,
    opacity: 0.45,
    side: DoubleSide,
    depthWrite: false,
  });
  private readonly cone = new Mesh(new ConeGeometry(1, 1, 32, 1, true), this.material);
  private readonly limit = new Mesh(
    this.cone.geometry,
    new MeshBasicMaterial({
      color: this.context.color,
      transparent: true,
      opacity: 0.1,
      side: DoubleSide,
      depthWrite: false,
    }),
  );

  constructor(context: DisplayContext) {
    super(context);
    this.group.add(this.cone, this.limit, axes(0.05));
  }

  protected draw(range: Range): void {
    const { min_range: min, max_range: max, field_of_view: fov } = range;
    // REP 117: -Inf is too near, +Inf is nothing within range. Fixed-distance rangers have min = max.
    const seen = Number.isFinite(range.range) && range.range > 0;
    this.cone.visible = seen && range.range <= max * 1.001 && (range.range >= min * 0.999 || min === max);
    if (this.cone.visible) this.stretch(this.cone, range.range, fov);
    this.limit.visible = Number.isFinite(max) && max > 0;
    if (this.limit.visible) this.stretch(this.limit, max, fov);
    // The picture shows the obstacle; the sensor's maximum range may be much farther away.
    this.limit.userData.isOutOfView = this.cone.visible;
  }

  private stretch(cone: Mesh, lengthM: number, fov: number): void {
    const angle = Math.min(Math.max(fov, 0.02), 3);
    const radiusM = lengthM * Math.tan(angle / 2);
    // The cone's tip is at +y; the beam leaves the sensor's origin along +x.
    cone.rotation.z = Math.PI / 2;
    cone.position.x = lengthM / 2;
    cone.scale.set(radiusM, lengthM, radiusM);
  }
}

/** sensor_msgs/Imu: a board in its attitude and an arrow for the acceleration. */
export class ImuDisplay extends HeaderDisplay<Imu> {
  private readonly body = new Group();
  private readonly acceleration = arrow(1, this.context.color, 0.02);

  constructor(context: DisplayContext) {
    super(context);
    const box = new BoxGeometry(0.3, 0.2, 0.03);
    const board = new Mesh(box, new MeshLambertMaterial({ color: "#1f7a5c" }));
    const edges = new LineSegments(new EdgesGeometry(box), new LineBasicMaterial({ color: "#9fd8c3" }));
    this.body.add(board, edges, axes(0.25));
    this.body.add(this.acceleration);
    this.group.add(this.body);
  }

  protected draw(imu: Imu): void {
    const { orientation: q, linear_acceleration: a } = imu;
    // sensor_msgs/Imu: a first covariance of -1 means no orientation.
    const oriented = (imu.orientation_covariance[0] as number) !== -1;
    this.body.quaternion.set(...(oriented ? normalized([q.x, q.y, q.z, q.w]) : ([0, 0, 0, 1] as const)));
    const vector = new Vector3(a.x, a.y, a.z);
    const size = vector.length();
    this.acceleration.visible = size > 0.05 && Number.isFinite(size);
    if (!this.acceleration.visible) return;
    this.acceleration.quaternion.setFromUnitVectors(new Vector3(1, 0, 0), vector.normalize());
    this.acceleration.scale.setScalar(Math.min(size / 9.81, 4) * 0.3);
  }
}

type ReadNumber = (view: DataView, at: number) => number;

function reader(field: PointField | undefined, little: boolean): ReadNumber | undefined {
  if (field === undefined) return undefined;
  const at = field.offset;
  switch (field.datatype) {
    case 1:
      return (view, base) => view.getInt8(base + at);
    case 2:
      return (view, base) => view.getUint8(base + at);
    case 3:
      return (view, base) => view.getInt16(base + at, little);
    case 4:
      return (view, base) => view.getUint16(base + at, little);
    case 5:
      return (view, base) => view.getInt32(base + at, little);
    case 6:
      return (view, base) => view.getUint32(base + at, little);
    case 7:
      return (view, base) => view.getFloat32(base + at, little);
    case 8:
      return (view, base) => view.getFloat64(base + at, little);
    default:
      return undefined;
  }
}

const FIELD_BYTES = [0, 1, 1, 2, 2, 4, 4, 4, 8];

/** sensor_msgs/PointCloud2: colored by rgb, intensity or height. */
export class PointCloudDisplay extends PointsDisplay<PointCloud2> {
  constructor(context: DisplayContext) {
    super(context, 2);
  }

  protected draw(cloud: PointCloud2): void {
    const { data, point_step: step, row_step: row, width, height, fields } = cloud;
    // An invalid message, or one without points, must remove the points of the previous one.
    this.geometry.setDrawRange(0, 0);
    if (width * height === 0) {
      this.context.report("");
      return;
    }
    const little = !cloud.is_bigendian;
    const named = (name: string) => fields.find((field) => field.name === name);
    const [x, y, z] = ["x", "y", "z"].map((name) => reader(named(name), little));
    const packed = named("rgb") ?? named("rgba");
    const fits =
      fields.every(({ offset, datatype }) => offset + (FIELD_BYTES[datatype] ?? 0) <= step) &&
      (packed?.offset ?? 0) + 4 <= step;
    const rows = height > 1 ? row : step * width;
    if (!x || !y || !z || !fits || step < 1 || rows < step * width || rows * height > data.length) {
      this.context.report("This point cloud's fields do not fit its data.");
      return;
    }
    this.context.report("");
    const total = Math.min(width * height, MAX_POINTS);
    const [positions, colors] = resizePoints(this.geometry, total);
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    const value = reader(named("intensity"), little);
    let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
    let count = 0;
    const shades = new Float32Array(packed ? 0 : total);
    for (let v = 0; v < height && count < total; v++) {
      for (let u = 0; u < width && count < total; u++) {
        const at = v * rows + u * step;
        const px = x(view, at);
        const py = y(view, at);
        const pz = z(view, at);
        if (!Number.isFinite(px + py + pz)) continue;
        positions[count * 3] = px;
        positions[count * 3 + 1] = py;
        positions[count * 3 + 2] = pz;
        if (packed) {
          // The bytes are b, g and r, whatever type the field has (the convention of PCL).
          const rgb = view.getUint32(at + packed.offset, little);
          colors[count * 3] = LINEAR[(rgb >> 16) & 255] as number;
          colors[count * 3 + 1] = LINEAR[(rgb >> 8) & 255] as number;
          colors[count * 3 + 2] = LINEAR[rgb & 255] as number;
        } else {
          const shade = value ? value(view, at) : pz;
          shades[count] = shade;
          if (shade < low) low = shade;
          if (shade > high) high = shade;
        }
        count++;
      }
    }
    if (!packed) {
      const scale = high > low ? 1 / (high - low) : 0;
      for (let i = 0; i < count; i++) rainbow(((shades[i] as number) - low) * scale, colors, i * 3);
    }
    this.geometry.setDrawRange(0, count);
  }
}

/** geometry_msgs/PointStamped. */
export class PointDisplay extends HeaderDisplay<{ point: { x: number; y: number; z: number } }> {
  private readonly ball = new Mesh(
    new SphereGeometry(0.04, 20, 12),
    new MeshLambertMaterial({ color: this.context.color }),
  );

  constructor(context: DisplayContext) {
    super(context);
    this.group.add(this.ball);
  }

  protected draw({ point }: { point: { x: number; y: number; z: number } }): void {
    this.ball.position.set(point.x, point.y, point.z);
  }
}
