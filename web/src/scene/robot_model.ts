// The robot of a URDF: its links at their frames, or moved by joint states if no node publishes the frames.
import { type Color, Group, LoadingManager, type Material, Mesh, type Object3D } from "three";
import URDFLoader, { type URDFRobot } from "urdf-loader";
import { type DisplayContext, disposeTree, type Placed } from "./display.ts";
import { loadMesh } from "./meshes.ts";

const EMPTY_TEXTURE = "data:image/gif;base64,R0lGODlhAQABAIAAAP///wAAACH5BAEAAAAALAAAAAABAAEAAAICRAEAOw==";

export class RobotModel {
  readonly links: readonly string[];
  private readonly robot: URDFRobot;
  private readonly visuals = new Map<string, Group>();
  /** The whole robot as one object, which is placed if tf has no frames of its links. */
  readonly whole: Object3D;

  /** @throws Error with a sentence when the description is not a URDF. */
  constructor(urdf: string, context: DisplayContext) {
    const manager = new LoadingManager();
    // Textures of links are not fetched: the page may load files of the robot through the gateway only.
    manager.setURLModifier(() => EMPTY_TEXTURE);
    const loader = new URDFLoader(manager);
    const materials = new Set<Material>();
    // Addresses stay as in the description; the gateway finds packages.
    loader.packages = (name: string) => `package://${name}`;
    loader.loadMeshCb = (uri, _manager, material, done) => {
      materials.add(material);
      // Without a material in the URDF, a Collada or OBJ file keeps its own.
      loadMesh(uri, context.fetchAsset, material.name === "" ? undefined : material)
        .then((mesh) => {
          done(mesh);
          context.invalidate();
        })
        .catch((error: unknown) => {
          context.report((error as Error).message);
          done(new Group());
        });
    };
    try {
      this.robot = loader.parse(urdf);
    } catch (error) {
      throw new Error(`The robot description is not a readable URDF: ${(error as Error).message}`);
    }
    this.robot.traverse((each) => {
      if (each instanceof Mesh) materials.add(each.material);
    });
    // The colors of a URDF are sRGB, but the loader treats them as linear.
    for (const each of materials) if ("color" in each) (each.color as Color).convertSRGBToLinear();
    this.links = Object.keys(this.robot.links);
    if (this.links.length === 0) throw new Error("The robot description has no links.");
    this.whole = new Group();
    this.whole.add(this.robot);
    for (const [name, link] of Object.entries(this.robot.links)) {
      const group = new Group();
      for (const child of [...link.children])
        if ((child as { isURDFVisual?: boolean }).isURDFVisual) group.add(child);
      this.visuals.set(name, group);
    }
    this.join();
  }

  get rootLink(): string {
    return this.links[0] as string;
  }

  /** Each link at its frame of tf. */
  *placed(): Iterable<Placed> {
    for (const [frame, object] of this.visuals) yield { frame, stampS: null, object };
  }

  /** Detaches the links, so that the view can place each one. */
  separate(): void {
    for (const group of this.visuals.values()) group.removeFromParent();
  }

  /** Puts the links back into one robot that joint states move. */
  join(): void {
    for (const [name, group] of this.visuals) {
      group.matrixAutoUpdate = true;
      group.position.set(0, 0, 0);
      group.quaternion.identity();
      group.visible = true;
      (this.robot.links[name] as Object3D).add(group);
    }
  }

  /** Applies a sensor_msgs/JointState. */
  moveJoints(names: readonly string[], positions: ArrayLike<number>): void {
    names.forEach((name, i) => {
      const position = positions[i];
      if (Number.isFinite(position) && name in this.robot.joints)
        this.robot.setJointValue(name, position as number);
    });
  }

  dispose(): void {
    for (const group of this.visuals.values()) disposeTree(group);
    disposeTree(this.whole);
  }
}
