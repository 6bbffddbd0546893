// The 3D picture: camera, light, ground and everything that displays draw, each at its frame.
import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  MathUtils,
  Object3D,
  PerspectiveCamera,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { type FrameTask, frameTask, limitFrames } from "../store/frames.ts";
import { texts } from "../texts.ts";
import { distanceToFit } from "./camera_fit.ts";
import { arrangeCaptions } from "./captions.ts";
import { expandByContent } from "./content_bounds.ts";
import type { Display, Placed } from "./display.ts";
import { cellFor, Ground } from "./ground.ts";
import type { Transform, Vec3 } from "./rigid.ts";
import { frameName, type TfBuffer } from "./tf_buffer.ts";

// 30 Hz looks smooth, and needs half the energy of 60 Hz.
const MIN_FRAME_MS = 30;
// Without a graphics card a picture takes the processor about 65 ms; a core must be left for other work.
const MIN_SOFTWARE_FRAME_MS = 400;
// Without a graphics card, each frame of the page costs a few milliseconds even if nothing is drawn.
const MIN_SOFTWARE_PAGE_FRAME_MS = 120;
const DIRECTIONS = {
  corner: new Vector3(0.75, -0.75, 0.55),
  // A little to the side, because from straight above no direction is up.
  top: new Vector3(-0.0001, 0, 1),
  front: new Vector3(1, 0, 0.1),
};

export interface Placement {
  readonly transform: Transform | undefined;
  readonly problem: string;
}

export class SceneView {
  readonly displays = new Map<string, Display>();
  /** Sentences about problems of displays, by their keys. */
  readonly problems = new Map<string, string>();
  fixedFrame = "";
  /** The camera moves with this frame; empty for none. */
  followedFrame = "";

  private readonly host: HTMLElement;
  private readonly tf: TfBuffer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(50, 1, 0.01, 2000);
  private readonly isSoftware = isSoftwareRendering();
  private readonly renderer = new WebGLRenderer({ antialias: !this.isSoftware });
  private readonly controls: OrbitControls;
  private readonly frame: FrameTask;
  private readonly resizes: ResizeObserver;
  private readonly drawn = new Map<string, Set<Object3D>>();
  private readonly followedAt = new Vector3();
  private readonly ground = new Ground();
  private lastDrawMs = 0;
  private isChanged = true;
  private hasMoved = false;
  /** Whether the user moves the camera. */
  private isTurning = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(host: HTMLElement, tf: TfBuffer) {
    this.host = host;
    this.tf = tf;
    Object3D.DEFAULT_UP.set(0, 0, 1);
    this.scene.up.set(0, 0, 1);
    this.camera.up.set(0, 0, 1);
    const canvas = this.renderer.domElement;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", texts.panels.scene);
    host.append(canvas);
    // For tests: where the axes of a frame are drawn.
    Object.assign(this.renderer.domElement, {
      axesAt: (frame: string) => {
        const found = this.scene.children.find((each) => each.name === frame);
        return found && [...found.position.toArray(), ...found.quaternion.toArray()];
      },
    });
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.maxPolarAngle = Math.PI * 0.98;
    this.controls.addEventListener("change", () => this.markDirty());
    this.controls.addEventListener("start", () => this.setTurning(true));
    this.controls.addEventListener("end", () => this.setTurning(false));
    this.setTurning(false);
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(3, -4, 8);
    this.scene.add(sun, new AmbientLight(0xffffff, 1.1), this.ground.lines);
    this.frame = frameTask(() => this.drawSoon());
    this.resizes = new ResizeObserver(() => this.resize());
    this.resizes.observe(host);
    this.applyTheme();
    this.resize();
    this.fit(new Box3(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 0.5)));
  }

  /** Reads the colors from the page's style again, after a switch between dark and light. */
  applyTheme(): void {
    const style = getComputedStyle(this.host);
    const color = (name: string, fallback: string) =>
      new Color(style.getPropertyValue(name).trim() || fallback);
    this.scene.background = color("--scene-background", "#14171c");
    this.ground.setColor(color("--scene-grid", "#3a404a"));
    this.markDirty();
  }

  /** Turns the camera to another side of the same point. */
  lookFrom(direction: keyof typeof DIRECTIONS): void {
    this.standAt(direction, this.camera.position.distanceTo(this.controls.target));
  }

  /** Shows the whole of a box, and lays the ground below it; returns the side of the ground's cells in meters. */
  fit(box: Box3): number {
    const halfAngle = MathUtils.degToRad(this.camera.fov) / 2;
    box.getCenter(this.controls.target);
    this.standAt("corner", distanceToFit(box, DIRECTIONS.corner, halfAngle, this.camera.aspect));
    const size = box.getSize(new Vector3());
    const cellM = cellFor(Math.max(size.x, size.y, size.z));
    this.ground.lay(cellM, this.controls.target.x, this.controls.target.y);
    return cellM;
  }

  private standAt(direction: keyof typeof DIRECTIONS, distanceM: number): void {
    const way = DIRECTIONS[direction].clone().normalize();
    this.camera.position.copy(way.multiplyScalar(distanceM)).add(this.controls.target);
    this.controls.update();
    this.markDirty();
  }

  /** Calls `onMove` when the user moves the camera, once. */
  onFirstMove(onMove: () => void): void {
    const listener = () => {
      this.controls.removeEventListener("start", listener);
      onMove();
    };
    this.controls.addEventListener("start", listener);
  }

  add(key: string, display: Display): void {
    this.remove(key);
    this.displays.set(key, display);
    this.markDirty();
  }

  remove(key: string): void {
    this.displays.get(key)?.dispose();
    this.displays.delete(key);
    this.problems.delete(key);
    for (const object of this.drawn.get(key) ?? []) object.removeFromParent();
    this.drawn.delete(key);
    this.markDirty();
  }

  /** Draws again. */
  markDirty(): void {
    this.isChanged = true;
    this.frame.markDirty();
  }

  /** Draws again if an object has moved: most transforms repeat the last pose. */
  markMoved(): void {
    this.frame.markDirty();
  }

  /** The box around a display, in the fixed frame; empty without content. */
  boundsOf(key: string): Box3 {
    const box = new Box3();
    for (const object of this.drawn.get(key) ?? []) box.expandByObject(object);
    return box;
  }

  /** The box around the drawn content of displays, in the fixed frame. */
  contentBounds(keys: Iterable<string>): Box3 {
    const box = new Box3();
    for (const key of keys) for (const object of this.drawn.get(key) ?? []) expandByContent(box, object);
    return box;
  }

  /** Whether a position in the fixed frame is inside the picture. */
  shows(position: Vec3): boolean {
    this.camera.updateMatrixWorld();
    const { x, y } = new Vector3(...position).project(this.camera);
    // At the edge, half of the robot is cut off; `fit` leaves more room.
    return Math.abs(x) < 0.9 && Math.abs(y) < 0.9;
  }

  dispose(): void {
    for (const key of [...this.displays.keys()]) this.remove(key);
    clearTimeout(this.timer);
    limitFrames(0);
    this.frame.dispose();
    this.resizes.disconnect();
    this.controls.dispose();
    this.ground.dispose();
    this.renderer.dispose();
    // Browsers allow only about 16 contexts, and free a forgotten one only with the next garbage collection.
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  /** The pose of an object in the fixed frame. Without a transform, it is drawn at the origin, with a notice. */
  place(frame: string, stampS: number | null): Placement {
    const from = frameName(frame);
    if (from === "" || from === frameName(this.fixedFrame)) return { transform: undefined, problem: "" };
    let found = this.tf.lookup(this.fixedFrame, from, stampS);
    // The stamp is newer than the transforms, or older than the history: the newest transform is the best guess.
    if (typeof found === "string" && stampS !== null) found = this.tf.lookup(this.fixedFrame, from, null);
    if (typeof found === "string") return { transform: undefined, problem: `${found} Drawn at the origin.` };
    return { transform: found.transform, problem: "" };
  }

  private setTurning(isTurning: boolean): void {
    this.isTurning = isTurning;
    limitFrames(this.isSoftware && !isTurning ? MIN_SOFTWARE_PAGE_FRAME_MS : 0);
  }

  private drawSoon(): void {
    const periodMs = this.isSoftware && !this.isTurning ? MIN_SOFTWARE_FRAME_MS : MIN_FRAME_MS;
    const waitMs = periodMs - (performance.now() - this.lastDrawMs);
    if (waitMs <= 2) this.draw();
    else this.timer ??= setTimeout(() => this.draw(), waitMs);
  }

  private draw(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.lastDrawMs = performance.now();
    for (const [key, display] of this.displays) this.placeDisplay(key, display);
    this.follow();
    if (!this.isChanged && !this.hasMoved) return;
    this.isChanged = this.hasMoved = false;
    const captions = [...this.displays.values()].flatMap((display) => display.captions ?? []);
    arrangeCaptions(captions, this.camera, this.renderer.getSize(new Vector2()));
    this.renderer.render(this.scene, this.camera);
  }

  private placeDisplay(key: string, display: Display): void {
    const before = this.drawn.get(key) ?? new Set<Object3D>();
    const now = new Set<Object3D>();
    let problem = "";
    for (const each of display.placed()) {
      const placement = this.place(each.frame, each.stampS);
      problem ||= placement.problem;
      if (applyTransform(each, placement.transform)) this.hasMoved = true;
      if (each.object.parent !== this.scene) {
        this.scene.add(each.object);
        this.hasMoved = true;
      }
      now.add(each.object);
    }
    for (const object of before) {
      if (now.has(object)) continue;
      object.removeFromParent();
      this.hasMoved = true;
    }
    this.drawn.set(key, now);
    if (problem === "") this.problems.delete(key);
    else this.problems.set(key, problem);
  }

  private follow(): void {
    if (this.followedFrame === "") return;
    const { transform } = this.place(this.followedFrame, null);
    if (transform === undefined) return;
    const moved = new Vector3(...transform.translation).sub(this.followedAt);
    this.followedAt.add(moved);
    this.camera.position.add(moved);
    this.controls.target.add(moved);
    this.camera.lookAt(this.controls.target);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.isSoftware ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.isChanged = true;
    this.draw();
  }
}

/** Places an object; returns whether it has moved. */
function applyTransform({ object }: Placed, transform: Transform | undefined): boolean {
  const [x, y, z] = transform?.translation ?? [0, 0, 0];
  const [i, j, k, w] = transform?.rotation ?? [0, 0, 0, 1];
  const { position: p, quaternion: q } = object;
  if (p.x === x && p.y === y && p.z === z && q.x === i && q.y === j && q.z === k && q.w === w) return false;
  p.set(x, y, z);
  q.set(i, j, k, w);
  return true;
}

/** Whether the browser draws 3D with the processor. */
function isSoftwareRendering(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
