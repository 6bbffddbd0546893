// Updates the 3D view from the graph and the user's choices.
import { effect, type Signal, signal } from "@preact/signals";
import { Box3, Vector3 } from "three";
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
import { color, type Theme, theme } from "../../shell/theme.ts";
import { frameTask } from "../../store/frames.ts";
import { texts } from "../../texts.ts";
import type { PanelContext } from "../panel.ts";

const ROBOT = "robot";
const FRAMES = "frames";
const MARKER_TYPES = ["visualization_msgs/Marker", "visualization_msgs/MarkerArray"];
/** Types that show the surroundings of a robot. */
const SURROUNDINGS = [
  ...MARKER_TYPES,
  "nav_msgs/OccupancyGrid",
  "nav_msgs/Path",
  "sensor_msgs/LaserScan",
  "sensor_msgs/PointCloud2",
  "sensor_msgs/Range",
];
const COLORS = ["#4c9aff", "#f5a524", "#36b37e", "#e5618a", "#9a6cf5", "#2bb8c4", "#d9c02f", "#f0734a"];
/** The first transforms arrive one after another: the camera is fitted again this many times, every half second. */
const FIT_TICKS = 3;
/** The camera does not fit itself to frames that are farther from the origin. */
const MAX_DISTANCE_M = 15;
/** Space around the frames of a robot whose shape is not known, for sensors and names. */
const MARGIN_M = 0.15;
/** If a frame was not received for this time, the panel reports it. */
const STALE_FRAME_MS = 3000;

export interface SceneSettings {
  /** Empty: chosen automatically. */
  fixedFrame?: string;
  followedFrame?: string;
  /** Keys of displays that are not shown. */
  hidden?: string[];
  /** Keys of the only displays that are shown; without it, all are. */
  only?: string[];
  /** A .rviz file on the server of the page, read at the start. */
  rviz?: string;
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
    // robot_state_publisher moves the links; without it, joint states move the joints of the model.
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
  /** The side of the ground's cells. */
  readonly cellM = signal(0);
  readonly view: SceneView;
  private readonly tf: TfBuffer;
  private readonly context: PanelContext;
  private readonly endings: (() => void)[] = [];
  private readonly subscriptions = new Map<string, () => void>();
  private readonly reports = new Map<string, string>();
  /** Topics with something to draw; true for those that show the surroundings. */
  private readonly contents = new Map<string, boolean>();
  private readonly pending = new Map<string, () => void>();
  private readonly updates = frameTask(() => this.runPending());
  private model: RobotModel | undefined;
  private treeVersion = -1;
  private drawnTheme: Theme | undefined;
  /** The box around the origin and all positions of frames. */
  private readonly visited = new Box3();
  private ticksToFit = 0;
  private hasMoved = false;

  constructor(host: HTMLElement, context: PanelContext) {
    this.context = context;
    this.tf = followTf(context, () => this.view.markMoved());
    this.view = new SceneView(host, this.tf);
    void this.startFromRviz();
    this.endings.push(
      followRobotDescription(context, (urdf) => this.showRobot(urdf)),
      effect(() => this.syncDisplays()),
    );
    const { feed, close } = context.subscribe("/joint_states", () => {
      this.queue(ROBOT, () => {
        const message = feed.lastValid();
        if (message) this.view.displays.get(ROBOT)?.update(message);
      });
    });
    this.forgetVisited();
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
    const { hidden = [], only } = this.settings;
    if (this.isShown(key)) this.change({ hidden: [...hidden, key] });
    else this.change({ hidden: hidden.filter((each) => each !== key), only: only && [...only, key] });
  }

  /**
   * Applies a .rviz file: its fixed frame, and only its displays.
   *
   * @throws Error with a sentence for the user.
   */
  applyRviz(text: string): void {
    const config = readRvizConfig(text);
    const wanted = config.displays.filter((each) => each.enabled);
    const only = wanted.map((each) => each.topic);
    if (wanted.some((each) => each.kind === "RobotModel")) only.push(ROBOT);
    if (wanted.some((each) => each.kind === "TF")) only.push(FRAMES);
    this.change({ fixedFrame: config.fixedFrame, hidden: [], only });
  }

  /** Applies the .rviz file that the link names. */
  private async startFromRviz(): Promise<void> {
    const { rviz } = this.settings;
    if (rviz === undefined || !/^[\w-]+\.rviz$/.test(rviz)) return;
    this.change({ rviz: undefined });
    const answer = await fetch(rviz).catch(() => undefined);
    if (!answer?.ok) return;
    try {
      this.applyRviz(await answer.text());
    } catch (error) {
      this.reports.set(ROBOT, (error as Error).message);
    }
  }

  private isShown(key: string): boolean {
    const { hidden = [], only } = this.settings;
    return !hidden.includes(key) && (only?.includes(key) ?? true);
  }

  /** Moves the camera so that the robot is in the picture, or everything with `all`. */
  fit(all = false): void {
    const box = this.extent();
    const hasRobot = this.view.displays.has(ROBOT);
    // Without a robot, the view shows what its sensors measure.
    const keys = [...this.contents].filter(([, isSurroundings]) => all || (isSurroundings && !hasRobot));
    box.union(this.view.contentBounds(keys.map(([key]) => key)));
    this.cellM.value = this.view.fit(box);
    const { x, y, z } = box.getSize(new Vector3());
    const frames = this.view.displays.get(FRAMES);
    if (frames instanceof TfDisplay) frames.fit(Math.max(x, y, z));
  }

  dispose(): void {
    for (const end of [...this.endings, ...this.subscriptions.values()]) end();
    this.updates.dispose();
    this.view.dispose();
  }

  /** The box around the robot and all positions of its frames since the tree of frames changed. */
  private extent(): Box3 {
    const robot = this.view.boundsOf(ROBOT);
    const marginM = robot.isEmpty() ? MARGIN_M : 0.02;
    for (const position of this.framePositions()) this.visited.expandByPoint(new Vector3(...position));
    return this.visited.clone().union(robot).expandByScalar(marginM);
  }

  /** The positions of the frames in the fixed frame, without those that are too far away for one picture. */
  private framePositions(): Vec3[] {
    return this.tf.frames().flatMap((frame) => {
      const found = this.tf.lookup(this.view.fixedFrame, frame);
      if (typeof found === "string" || Math.hypot(...found.transform.translation) > MAX_DISTANCE_M) return [];
      return [found.transform.translation];
    });
  }

  /** Whether a robot drove out of the picture. */
  private hasLeftPicture(): boolean {
    return (
      !this.settings.followedFrame && this.framePositions().some((position) => !this.view.shows(position))
    );
  }

  private drawable(): string[] {
    return [...this.context.robot.topics.value.values()]
      .filter((topic) => topic.typeName in DISPLAYS && topic.channelId !== undefined)
      .map((topic) => topic.name)
      .sort();
  }

  private syncDisplays(): void {
    if (theme.value !== this.drawnTheme) {
      this.drawnTheme = theme.value;
      this.view.applyTheme();
      // The names of frames are drawn again below.
      this.view.remove(FRAMES);
    }
    const topics = this.drawable();
    const wanted = new Set(topics.filter((topic) => this.isShown(topic)));
    for (const [key, close] of this.subscriptions) {
      if (wanted.has(key)) continue;
      close();
      this.subscriptions.delete(key);
      this.view.remove(key);
      this.reports.delete(key);
      this.contents.delete(key);
    }
    topics.forEach((topic, i) => {
      if (wanted.has(topic) && !this.subscriptions.has(topic))
        this.subscriptions.set(topic, this.show(topic, COLORS[i % COLORS.length] as string));
    });
    if (!this.isShown(FRAMES)) this.view.remove(FRAMES);
    else if (!this.view.displays.has(FRAMES)) {
      this.view.add(FRAMES, new TfDisplay(this.tf, color("--text"), color("--scene-background")));
    }
    if (!this.isShown(ROBOT)) this.view.remove(ROBOT);
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
        if (!this.contents.has(topic)) {
          this.contents.set(topic, SURROUNDINGS.includes(type));
          this.ticksToFit = FIT_TICKS;
        }
      } catch (error) {
        this.reports.set(topic, texts.scene.undecodable((error as Error).message));
      }
      this.view.markDirty();
    };
    // Every marker is drawn; of other topics, only the newest message of each picture.
    const isMarkers = MARKER_TYPES.includes(type);
    const listener = isMarkers ? draw : () => this.queue(topic, draw);
    const { feed, close } = this.context.subscribe(topic, listener, isMarkers);
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
      const context = this.displayContext(ROBOT, "#b8bcc4");
      const invalidate = () => {
        // A loaded mesh may be larger than the previous content; the camera is fitted again when it is drawn.
        this.ticksToFit = 2;
        context.invalidate();
      };
      this.model = new RobotModel(urdf, { ...context, invalidate });
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
    this.forgetVisited();
    this.view.markDirty();
  }

  private forgetVisited(): void {
    this.visited.makeEmpty().expandByPoint(new Vector3());
  }

  private firstMessageFrame(): string {
    for (const display of this.view.displays.values())
      for (const placed of display.placed()) if (placed.frame !== "") return frameName(placed.frame);
    return "";
  }

  private refreshRows(): void {
    if (this.treeVersion !== this.tf.treeVersion) {
      this.treeVersion = this.tf.treeVersion;
      this.forgetVisited();
      this.frames.value = this.tf.frames();
      this.chooseFixedFrame();
      this.ticksToFit = FIT_TICKS;
    } else if (this.view.fixedFrame === "") this.chooseFixedFrame();
    if (!this.hasMoved && (this.ticksToFit > 0 || this.hasLeftPicture())) {
      this.ticksToFit = Math.max(0, this.ticksToFit - 1);
      this.fit();
    }
    const row = (key: string, title: string, type: string): Row => ({
      key,
      title,
      type,
      isShown: this.isShown(key),
      problem: !this.isShown(key) ? "" : (this.reports.get(key) ?? this.view.problems.get(key) ?? ""),
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
