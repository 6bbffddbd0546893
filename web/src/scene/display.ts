// Draws the messages of one topic.
import { type BufferGeometry, type Material, type Mesh, Object3D, Sprite } from "three";
import type { Caption } from "./captions.ts";
import type { Xyz, Xyzw } from "./messages.ts";
import { normalized } from "./rigid.ts";

/** An object with a pose in one frame; the view keeps it there as frames move. */
export interface Placed {
  readonly frame: string;
  /** Seconds; null follows the newest transform. */
  readonly stampS: number | null;
  readonly object: Object3D;
}

export interface Display {
  /** Draws a decoded message. */
  update(message: unknown): void;
  /** The placed objects. Most displays have one, markers many. */
  placed(): Iterable<Placed>;
  /** The names in placed objects, the most important first. */
  readonly captions?: readonly Caption[];
  dispose(): void;
}

export interface DisplayContext {
  /** A file of a robot description or marker: package:// or file://. */
  fetchAsset(uri: string): Promise<Uint8Array>;
  /** Something has changed outside of `update`, such as a mesh that was loaded. */
  invalidate(): void;
  /** A sentence for the user about this display; empty without a problem. */
  report(problem: string): void;
  /** Color of this topic, from the page's series colors. */
  readonly color: string;
}

export type MakeDisplay = (context: DisplayContext) => Display;

/** A display of one object whose message has a header. */
export abstract class HeaderDisplay<Message> implements Display {
  protected readonly group = new Object3D();
  private frame = "";
  private stampS: number | null = null;
  protected readonly context: DisplayContext;

  constructor(context: DisplayContext) {
    this.context = context;
  }

  update(message: unknown): void {
    const { header } = message as { header: { stamp: { sec: number; nsec: number }; frame_id: string } };
    this.frame = header.frame_id;
    const stampS = header.stamp.sec + header.stamp.nsec * 1e-9;
    this.stampS = stampS === 0 ? null : stampS;
    this.draw(message as Message);
  }

  *placed(): Iterable<Placed> {
    if (this.frame !== "" || this.group.children.length > 0)
      yield { frame: this.frame, stampS: this.stampS, object: this.group };
  }

  dispose(): void {
    disposeTree(this.group);
  }

  protected abstract draw(message: Message): void;
}

/** Releases the resources of an object on the graphics card. */
export function disposeTree(root: Object3D): void {
  root.removeFromParent();
  root.traverse((object) => {
    const { geometry, material } = object as Partial<Pick<Mesh, "geometry" | "material">>;
    // All sprites share one geometry.
    if (!(object instanceof Sprite)) (geometry as BufferGeometry | undefined)?.dispose();
    const materials = (Array.isArray(material) ? material : [material]) as (Material | undefined)[];
    for (const each of materials) {
      (each as { map?: { dispose(): void } | null } | undefined)?.map?.dispose();
      each?.dispose();
    }
  });
}

/** Puts an object at a pose. An orientation of all zeros means no rotation. */
export function setPose(object: Object3D, position: Xyz, orientation: Xyzw): void {
  object.position.set(position.x, position.y, position.z);
  object.quaternion.set(...normalized([orientation.x, orientation.y, orientation.z, orientation.w]));
}
