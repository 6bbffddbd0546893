// visualization_msgs/Marker and MarkerArray.
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  DoubleSide,
  Group,
  InstancedMesh,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  Points,
  PointsMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
} from "three";
import { toLinear } from "./colors.ts";
import { type Display, type DisplayContext, disposeTree, type Placed, setPose } from "./display.ts";
import { loadMesh } from "./meshes.ts";
import type { Marker, Rgba, Xyz } from "./messages.ts";
import { arrow, label } from "./shapes.ts";

// visualization_msgs/Marker: the constants of `type` and `action`.
const ARROW = 0;
const CUBE = 1;
const SPHERE = 2;
const CYLINDER = 3;
const LINE_STRIP = 4;
const LINE_LIST = 5;
const CUBE_LIST = 6;
const SPHERE_LIST = 7;
const POINTS = 8;
const TEXT_VIEW_FACING = 9;
const MESH_RESOURCE = 10;
const TRIANGLE_LIST = 11;
const DELETE = 2;
const DELETE_ALL = 3;

/** More than RViz draws smoothly; a flood of new ids must not fill the memory. */
const MAX_MARKERS = 5000;
const MAX_MARKER_POINTS = 500_000;
// A timer of a browser counts milliseconds in 31 bits.
const LONGEST_TIMER_MS = 2 ** 31 - 2;

interface Shown extends Placed {
  readonly expiresMs: number;
}

/** Draws markers until they are deleted, replaced or expire. */
export class MarkerDisplay implements Display {
  private readonly shown = new Map<string, Shown>();
  private readonly context: DisplayContext;
  private expiryTimer: ReturnType<typeof setTimeout> | undefined;

  constructor(context: DisplayContext) {
    this.context = context;
  }

  update(message: unknown): void {
    const markers = (message as { markers?: Marker[] }).markers ?? [message as Marker];
    for (const marker of markers) this.apply(marker);
  }

  *placed(): Iterable<Placed> {
    const now = performance.now();
    let nextMs = Number.POSITIVE_INFINITY;
    for (const [key, each] of this.shown) {
      if (now >= each.expiresMs) this.remove(key);
      else {
        nextMs = Math.min(nextMs, each.expiresMs);
        yield each;
      }
    }
    // The next marker that expires must vanish even if nothing else changes the picture.
    clearTimeout(this.expiryTimer);
    // Timers drop fractions of milliseconds, and must not be early.
    const waitMs = Math.ceil(nextMs - now) + 1;
    if (waitMs <= LONGEST_TIMER_MS) this.expiryTimer = setTimeout(() => this.context.invalidate(), waitMs);
  }

  dispose(): void {
    clearTimeout(this.expiryTimer);
    for (const key of [...this.shown.keys()]) this.remove(key);
  }

  private apply(marker: Marker): void {
    const key = `${marker.ns}/${marker.id}`;
    if (marker.action === DELETE_ALL) {
      this.dispose();
      return;
    }
    this.remove(key);
    if (marker.action === DELETE) return;
    if (this.shown.size >= MAX_MARKERS) {
      this.context.report(`Only ${MAX_MARKERS} markers are drawn.`);
      return;
    }
    if (!hasFiniteNumbers(marker)) {
      this.context.report(`The marker ${key} has numbers that are not finite.`);
      return;
    }
    const object = this.draw(marker);
    if (object === undefined) return;
    setPose(object, marker.pose.position, marker.pose.orientation);
    // The view places `holder`; the marker's own pose stays inside.
    const holder = new Group();
    holder.add(object);
    const { sec, nsec } = marker.lifetime;
    const lifeMs = sec * 1000 + nsec / 1e6;
    const stampS = marker.header.stamp.sec + marker.header.stamp.nsec * 1e-9;
    this.shown.set(key, {
      frame: marker.header.frame_id,
      stampS: marker.frame_locked || stampS === 0 ? null : stampS,
      object: holder,
      expiresMs: lifeMs > 0 ? performance.now() + lifeMs : Number.POSITIVE_INFINITY,
    });
  }

  private remove(key: string): void {
    const each = this.shown.get(key);
    if (each === undefined) return;
    disposeTree(each.object);
    this.shown.delete(key);
  }

  private draw(marker: Marker): Object3D | undefined {
    const { scale, type } = marker;
    const group = new Group();
    const add = (object: Object3D) => {
      group.add(object);
      return group;
    };
    const solid = () => material(marker.color);
    switch (type) {
      case ARROW:
        return add(arrowOf(marker));
      case CUBE: {
        return add(scaled(new Mesh(new BoxGeometry(1, 1, 1), solid()), scale));
      }
      case SPHERE:
        return add(scaled(new Mesh(new SphereGeometry(0.5, 24, 16), solid()), scale));
      case CYLINDER: {
        const geometry = new CylinderGeometry(0.5, 0.5, 1, 24);
        geometry.rotateX(Math.PI / 2);
        return add(scaled(new Mesh(geometry, solid()), scale));
      }
      case LINE_STRIP:
        return add(new Line(pointsOf(marker), lineMaterial(marker)));
      case LINE_LIST:
        return add(new LineSegments(pointsOf(marker), lineMaterial(marker)));
      case CUBE_LIST:
        return add(instances(marker, new BoxGeometry(1, 1, 1)));
      case SPHERE_LIST:
        return add(instances(marker, new SphereGeometry(0.5, 12, 8)));
      case POINTS: {
        const colored = marker.colors.length === marker.points.length;
        const points = new PointsMaterial({ size: Math.max(scale.x, 0.001), vertexColors: colored });
        if (!colored) points.color = colorOf(marker.color);
        return add(new Points(pointsOf(marker), points));
      }
      case TEXT_VIEW_FACING:
        return add(label(marker.text, Math.max(scale.z, 0.01), `#${colorOf(marker.color).getHexString()}`));
      case MESH_RESOURCE: {
        if (marker.mesh_resource === "") {
          this.context.report(`The marker ${marker.ns}/${marker.id} names no mesh.`);
          return undefined;
        }
        loadMesh(marker.mesh_resource, this.context.fetchAsset, marker.color.a > 0 ? solid() : undefined)
          .then((mesh) => {
            group.add(scaled(mesh, scale));
            this.context.invalidate();
          })
          .catch((error: unknown) => this.context.report(String((error as Error).message)));
        return group;
      }
      case TRIANGLE_LIST: {
        const geometry = pointsOf(marker);
        geometry.computeVertexNormals();
        const colored = geometry.hasAttribute("color");
        const painted = new MeshLambertMaterial({ side: DoubleSide, vertexColors: colored });
        if (!colored) painted.color = colorOf(marker.color);
        return add(scaled(new Mesh(geometry, painted), scale));
      }
      default:
        this.context.report(`Markers of type ${type} are not drawn.`);
        return undefined;
    }
  }
}

function colorOf({ r, g, b }: Rgba): Color {
  return new Color(toLinear(r), toLinear(g), toLinear(b));
}

/** Whether all numbers of a marker are finite; RViz does not draw others either. */
function hasFiniteNumbers({ pose, scale, points }: Marker): boolean {
  const { position, orientation } = pose;
  return (
    [position, orientation, scale].every(isFiniteVector) &&
    Number.isFinite(orientation.w) &&
    points.every(isFiniteVector)
  );
}

function isFiniteVector({ x, y, z }: Xyz): boolean {
  return Number.isFinite(x + y + z);
}

function material(color: Rgba): MeshLambertMaterial {
  const translucent = color.a < 1;
  return new MeshLambertMaterial({
    color: colorOf(color),
    transparent: translucent,
    opacity: color.a,
    depthWrite: !translucent,
  });
}

function lineMaterial(marker: Marker): LineBasicMaterial {
  const colored = marker.colors.length === marker.points.length && marker.colors.length > 0;
  const lines = new LineBasicMaterial({ vertexColors: colored });
  if (!colored) lines.color = colorOf(marker.color);
  return lines;
}

function scaled<T extends Object3D>(object: T, { x, y, z }: Xyz): T {
  object.scale.set(x || 1e-6, y || 1e-6, z || 1e-6);
  return object;
}

function pointsOf({ points, colors }: Marker): BufferGeometry {
  const count = Math.min(points.length, MAX_MARKER_POINTS);
  const positions = new Float32Array(count * 3);
  for (let i = 0; i < count; i++) {
    const { x, y, z } = points[i] as Xyz;
    positions.set([x, y, z], i * 3);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  if (colors.length === points.length && count > 0) {
    const shades = new Float32Array(count * 3);
    for (let i = 0; i < count; i++) {
      const { r, g, b } = colors[i] as Rgba;
      shades.set([toLinear(r), toLinear(g), toLinear(b)], i * 3);
    }
    geometry.setAttribute("color", new BufferAttribute(shades, 3));
  }
  return geometry;
}

function instances(marker: Marker, geometry: BufferGeometry): InstancedMesh {
  const count = Math.min(marker.points.length, MAX_MARKER_POINTS);
  const mesh = new InstancedMesh(geometry, material(marker.color), count);
  const colored = marker.colors.length === marker.points.length;
  if (colored) (mesh.material as MeshLambertMaterial).color = new Color(1, 1, 1);
  const { x: sx, y: sy, z: sz } = marker.scale;
  const matrix = new Matrix4();
  const size = new Vector3(sx || 1e-6, sy || 1e-6, sz || 1e-6);
  const unturned = new Quaternion();
  const at = new Vector3();
  for (let i = 0; i < count; i++) {
    const { x, y, z } = marker.points[i] as Xyz;
    mesh.setMatrixAt(i, matrix.compose(at.set(x, y, z), unturned, size));
    if (colored) mesh.setColorAt(i, colorOf(marker.colors[i] as Rgba));
  }
  mesh.frustumCulled = false;
  return mesh;
}

/** An arrow of length x and width y along the pose's x axis, or from the first point to the second. */
function arrowOf(marker: Marker): Object3D {
  const [from, to] = marker.points;
  const color = `#${colorOf(marker.color).getHexString()}`;
  if (from === undefined || to === undefined) {
    const { x, y } = marker.scale;
    return arrow(Math.max(x, 1e-3), color, Math.max(y / 2, 1e-4));
  }
  const way = new Vector3(to.x - from.x, to.y - from.y, to.z - from.z);
  const object = arrow(Math.max(way.length(), 1e-3), color, Math.max(marker.scale.x / 2, 1e-4));
  object.position.set(from.x, from.y, from.z);
  object.quaternion.setFromUnitVectors(new Vector3(1, 0, 0), way.normalize());
  return object;
}
