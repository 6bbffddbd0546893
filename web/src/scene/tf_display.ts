// The frames of tf: axes with their names, and a line to each parent.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments } from "three";
import { Caption } from "./captions.ts";
import { type Display, disposeTree, type Placed } from "./display.ts";
import { axes } from "./shapes.ts";
import type { TfBuffer } from "./tf_buffer.ts";

/** A humanoid has about 100 frames; more labels than this cannot be read. */
const MAX_SHOWN = 300;
const MAX_AXIS_M = 0.15;
const MIN_AXIS_M = 0.01;
/** The length of an axis, as a fraction of the robot's size. */
const AXIS_PART = 0.3;

export class TfDisplay implements Display {
  readonly captions: Caption[] = [];
  private readonly tf: TfBuffer;
  private readonly color: string;
  private readonly background: string;
  private readonly shown = new Map<string, Group>();
  private readonly parents = new Map<string, LineSegments>();
  private version = -1;
  private lengthM = MAX_AXIS_M;

  constructor(tf: TfBuffer, color: string, background: string) {
    this.tf = tf;
    this.color = color;
    this.background = background;
  }

  update(): void {}

  /** Fits the axes to a robot of this size. */
  fit(sizeM: number): void {
    const lengthM = Math.max(MIN_AXIS_M, Math.min(MAX_AXIS_M, sizeM * AXIS_PART));
    if (lengthM === this.lengthM) return;
    this.lengthM = lengthM;
    this.version = -1;
  }

  *placed(): Iterable<Placed> {
    if (this.version !== this.tf.treeVersion) this.rebuild();
    for (const [frame, object] of this.shown) yield { frame, stampS: null, object };
    for (const [child, object] of this.parents) {
      const edge = this.tf.edges.get(child);
      const newest = edge?.samples.at(-1);
      if (edge === undefined || newest === undefined) continue;
      const position = object.geometry.getAttribute("position") as BufferAttribute;
      const [x, y, z] = newest.transform.translation;
      if (position.getX(1) !== x || position.getY(1) !== y || position.getZ(1) !== z) {
        position.setXYZ(1, x, y, z);
        position.needsUpdate = true;
      }
      yield { frame: edge.parent, stampS: null, object };
    }
  }

  dispose(): void {
    for (const each of [...this.shown.values(), ...this.parents.values()]) disposeTree(each);
    this.shown.clear();
    this.parents.clear();
    this.captions.length = 0;
  }

  private rebuild(): void {
    this.version = this.tf.treeVersion;
    this.dispose();
    for (const frame of this.tf.frames().slice(0, MAX_SHOWN)) {
      const group = new Group();
      group.name = frame;
      const caption = new Caption(frame, this.color, this.background);
      this.captions.push(caption);
      group.add(axes(this.lengthM), caption);
      this.shown.set(frame, group);
      if (!this.tf.edges.has(frame)) continue;
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(6), 3));
      const line = new LineSegments(geometry, new LineBasicMaterial({ color: "#d6a11d" }));
      line.frustumCulled = false;
      this.parents.set(frame, line);
    }
  }
}
