// Keeps the 3D view equal to what is on the graph and what the user chose.
import { effect, type Signal, signal } from "@preact/signals";
import type { Display, DisplayContext, Placed } from "../../scene/display.ts";
import type { DisplayType } from "../../scene/display_types.ts";
import { DISPLAYS } from "../../scene/displays.ts";
import type { Vec3 } from "../../scene/rigid.ts";
import { followRobotDescription } from "../../scene/robot_description.ts";
import { RobotModel } from "../../scene/robot_model.ts";
import { readRvizConfig } from "../../scene/rviz_config.ts";
import type { TfBuffer } from "../../scene/tf_buffer.ts";
import { frameName } from "../../scene/tf_buffer.ts";
import { TfDisplay } from "../../scene/tf_display.ts";
import { followTf, likelyFixedFrame } from "../../scene/tf_feed.ts";
import { SceneView } from "../../scene/view.ts";
import { frameTask } from "../../store/frames.ts";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";

export const ROBOT = "robot";
export const FRAMES = "frames";
const MARKER_TYPES = ["visualization_msgs/Marker", "visualization_msgs/MarkerArray"];
const COLORS = ["#4c9aff", "#f5a524", "#36b37e", "#e5618a", "#9a6cf5", "#2bb8c4", "#d9c02f", "#f0734a"];
/** The first transforms come one after another: the camera fits itself for so many half seconds. */
const FIT_TICKS = 3;
/** Frames older than this while others move are named. */
const STALE_FRAME_MS = 3000;

export interface SceneSettings {
  /** Empty chooses by itself. */
  fixedFrame?: string;
  followedFrame?: string;
  /** Keys of displays that are not shown. */
  hidden?: string[];
}

/** A row of the list beside the picture. */
export interface Row {
  readonly key: string;
  readonly title: string;
  readonly type: string;
  readonly isShown: boolean;
  readonly problem: string;
}

class RobotDisplay implements Display {
  private readonly model: RobotModel;
  private readonly tf: TfBuffer;
  private isApart = false;

  constructor(model: RobotModel, tf: TfBuffer) {
    this.model = model;
    this.tf = tf;
  }

  update(message: unknown): void {
    const { name, position } = message as { name: string[]; position: ArrayLike<number> };
    this.model.moveJoints(name, position);
  }

  *placed(): Iterable<Placed> {
    // robot_state_publisher moves the links; without it joint states move the joints of one piece.
    const hasFrames = this.model.links.some((link) => this.tf.edges.has(link));
    if (hasFrames !== this.isApart) {
      this.isApart = hasFrames;
      if (hasFrames) this.model.separate();
      else this.model.join();
    }
    if (hasFrames) yield* this.model.placed();
    else yield { frame: "", stampS: null, object: this.model.whole };
  }

  dispose(): void {
    this.model.dispose();
  }
}

export class SceneStage {
  readonly rows: Signal<Row[]> = signal([]);
  readonly frames: Signal<string[]> = signal([]);
  readonly fixedFrame = signal("");
  readonly view: SceneView;
  private readonly tf: TfBuffer;
  private readonly context: PanelContext;
  private readonly endings: (() => void)[] = [];
  private readonly subscriptions = new Map<string, () => void>();
  private readonly reports = new Map<string, string>();
  private readonly pending = new Map<string, () => void>();
  private readonly updates = frameTask(() => this.runPending());
  private model: RobotModel | undefined;
  private treeVersion = -1;
  private ticksToFit = 0;
  private hasMoved = false;

  constructor(host: HTMLElement, context: PanelContext) {
    this.context = context;
    this.tf = followTf(context, () => this.view.markDirty());
    this.view = new SceneView(host, this.tf);
    this.endings.push(
      followRobotDescription(context, (urdf) => this.showRobot(urdf)),
      effect(() => this.syncDisplays()),
    );
    const { feed, close } = context.subscribe("/joint_states", () => {
      this.queue(ROBOT, () => {
        const message = feed.lastMessage();
        if (message !== undefined && !(message instanceof Error))
          this.view.displays.get(ROBOT)?.update(message);
      });
    });
    this.view.onFirstMove(() => {
      this.hasMoved = true;
    });
    const timer = setInterval(() => this.refreshRows(), 500);
    this.endings.push(close, () => clearInterval(timer));
    this.refreshRows();
  }

  get settings(): SceneSettings {
    return this.context.settings.value as SceneSettings;
  }

  change(change: SceneSettings): void {
    this.context.settings.value = { ...this.settings, ...change };
  }

  toggle(key: string): void {
    const hidden = new Set(this.settings.hidden ?? []);
    if (!hidden.delete(key)) hidden.add(key);
    this.change({ hidden: [...hidden] });
  }

  /** Start from a .rviz file: its fixed frame, and only its displays. Throws with a sentence. */
  applyRviz(text: string): void {
    const config = readRvizConfig(text);
    const wanted = config.displays.filter((each) => each.enabled);
    const topics = new Set(wanted.map((each) => each.topic));
    const hidden = this.drawable().filter((topic) => !topics.has(topic));
    if (!wanted.some((each) => each.kind === "RobotModel")) hidden.push(ROBOT);
    if (!wanted.some((each) => each.kind === "TF")) hidden.push(FRAMES);
    this.change({ fixedFrame: config.fixedFrame, hidden });
  }

  /** Move the camera so that everything is in the picture. */
  fit(): void {
    const { center, sizeM } = this.extent();
    this.view.lookFrom(sizeM * 2.2 + 0.3, "corner", center);
  }

  dispose(): void {
    for (const end of [...this.endings, ...this.subscriptions.values()]) end();
    this.updates.dispose();
    this.view.dispose();
  }

  /** The box around all frames: its middle, and its longest side, at most 30 m. */
  private extent(): { center: Vec3; sizeM: number } {
    const low: [number, number, number] = [0, 0, 0];
    const high: [number, number, number] = [0, 0, 0];
    for (const frame of this.tf.frames()) {
      const found = this.tf.lookup(this.view.fixedFrame, frame);
      if (typeof found === "string") continue;
      for (const i of [0, 1, 2] as const) {
        low[i] = Math.min(low[i], found.transform.translation[i]);
        high[i] = Math.max(high[i], found.transform.translation[i]);
      }
    }
    const middle = (i: 0 | 1 | 2) => (low[i] + high[i]) / 2;
    const sizeM = Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2], 0.5);
    return { center: [middle(0), middle(1), middle(2)], sizeM: Math.min(sizeM, 30) };
  }

  private drawable(): string[] {
    return [...this.context.robot.topics.value.values()]
      .filter((topic) => topic.typeName in DISPLAYS && topic.channelId !== undefined)
      .map((topic) => topic.name)
      .sort();
  }

  private syncDisplays(): void {
    const hidden = new Set(this.settings.hidden ?? []);
    const topics = this.drawable();
    const wanted = new Set(topics.filter((topic) => !hidden.has(topic)));
    for (const [key, close] of this.subscriptions) {
      if (wanted.has(key)) continue;
      close();
      this.subscriptions.delete(key);
      this.view.remove(key);
      this.reports.delete(key);
    }
    topics.forEach((topic, i) => {
      if (wanted.has(topic) && !this.subscriptions.has(topic))
        this.subscriptions.set(topic, this.show(topic, COLORS[i % COLORS.length] as string));
    });
    if (hidden.has(FRAMES)) this.view.remove(FRAMES);
    else if (!this.view.displays.has(FRAMES)) {
      const color = getComputedStyle(document.documentElement).getPropertyValue("--text") || "#ccc";
      this.view.add(FRAMES, new TfDisplay(this.tf, color));
    }
    if (hidden.has(ROBOT)) this.view.remove(ROBOT);
    else if (this.model !== undefined && !this.view.displays.has(ROBOT))
      this.view.add(ROBOT, new RobotDisplay(this.model, this.tf));
    this.view.followedFrame = this.settings.followedFrame ?? "";
    this.chooseFixedFrame();
    this.view.markDirty();
  }

  private show(topic: string, color: string): () => void {
    const { robot } = this.context;
    const type = robot.topics.peek().get(topic)?.typeName ?? "";
    const display = DISPLAYS[type as DisplayType](this.displayContext(topic, color));
    this.view.add(topic, display);
    const draw = () => {
      const message = feed.lastMessage();
      if (message === undefined) return;
      try {
        if (message instanceof Error) throw message;
        display.update(message);
      } catch (error) {
        this.reports.set(topic, texts.scene.undecodable((error as Error).message));
      }
      this.view.markDirty();
    };
    // Each marker counts; of sensors only the newest is drawn.
    const listener = MARKER_TYPES.includes(type) ? draw : () => this.queue(topic, draw);
    const { feed, close } = this.context.subscribe(topic, listener);
    if (feed.last !== undefined) this.queue(topic, draw);
    return close;
  }

  private queue(key: string, run: () => void): void {
    this.pending.set(key, run);
    this.updates.markDirty();
  }

  private runPending(): void {
    const runs = [...this.pending.values()];
    this.pending.clear();
    for (const run of runs) run();
    this.view.markDirty();
  }

  private displayContext(key: string, color: string): DisplayContext {
    return {
      color,
      fetchAsset: (uri) => this.context.robot.gateway.fetchAsset(uri),
      invalidate: () => this.view.markDirty(),
      report: (problem) => {
        if (problem === "") this.reports.delete(key);
        else this.reports.set(key, problem);
      },
    };
  }

  private showRobot(urdf: string): void {
    this.view.remove(ROBOT);
    this.model = undefined;
    this.reports.delete(ROBOT);
    try {
      this.model = new RobotModel(urdf, this.displayContext(ROBOT, "#b8bcc4"));
    } catch (error) {
      this.reports.set(ROBOT, (error as Error).message);
    }
    this.syncDisplays();
    if (!this.hasMoved) this.fit();
  }

  private chooseFixedFrame(): void {
    const first = this.firstMessageFrame();
    const chosen = this.settings.fixedFrame || likelyFixedFrame(this.tf, this.model?.rootLink ?? first);
    if (chosen === this.view.fixedFrame) return;
    this.view.fixedFrame = chosen;
    this.fixedFrame.value = chosen;
    this.view.markDirty();
  }

  private firstMessageFrame(): string {
    for (const display of this.view.displays.values())
      for (const placed of display.placed()) if (placed.frame !== "") return frameName(placed.frame);
    return "";
  }

  private refreshRows(): void {
    if (this.treeVersion !== this.tf.treeVersion) {
      this.treeVersion = this.tf.treeVersion;
      this.frames.value = this.tf.frames();
      this.chooseFixedFrame();
      this.ticksToFit = FIT_TICKS;
    } else if (this.view.fixedFrame === "") this.chooseFixedFrame();
    if (this.ticksToFit > 0 && !this.hasMoved) {
      this.ticksToFit--;
      this.fit();
    }
    const hidden = new Set(this.settings.hidden ?? []);
    const row = (key: string, title: string, type: string): Row => ({
      key,
      title,
      type,
      isShown: !hidden.has(key),
      problem: hidden.has(key) ? "" : (this.reports.get(key) ?? this.view.problems.get(key) ?? ""),
    });
    const rows: Row[] = [];
    if (this.model !== undefined || this.reports.has(ROBOT)) rows.push(row(ROBOT, texts.scene.robot, "URDF"));
    if (this.tf.edges.size > 0)
      rows.push({ ...row(FRAMES, texts.scene.frames, "tf"), problem: this.staleFrames() });
    for (const topic of this.drawable())
      rows.push(row(topic, topic, this.context.robot.topics.peek().get(topic)?.typeName ?? ""));
    if (JSON.stringify(rows) !== JSON.stringify(this.rows.peek())) this.rows.value = rows;
  }

  private staleFrames(): string {
    const now = performance.now();
    const ages = [...this.tf.edges.values()].filter((edge) => !edge.isStatic);
    const oldest = ages.reduce((a, b) => (a === undefined || b.receivedMs < a.receivedMs ? b : a), ages[0]);
    if (oldest === undefined || now - oldest.receivedMs < STALE_FRAME_MS) return "";
    return texts.scene.staleFrame(oldest.child, Math.round((now - oldest.receivedMs) / 1000));
  }
}
