// This device as a source of sensor topics: its name, and the sensors that are on. They pause while the page is hidden.
import { effect, type Signal, signal } from "@preact/signals";
import { newDeviceName } from "../store/device_name.ts";
import { RateMeter } from "../store/rate.ts";
import { loadSetting, saveSetting } from "../store/storage.ts";
import { pageHidden } from "../store/visibility.ts";
import { encoder } from "../wire/encode.ts";
import { battery } from "./battery.ts";
import { camera } from "./camera.ts";
import { phoneType } from "./definitions.ts";
import { gps } from "./gps.ts";
import { imu } from "./imu.ts";
import { PhoneLink } from "./phone_link.ts";
import { type Problem, type Sensor, SensorError, type SensorSettings } from "./sensor.ts";

const DEFAULTS: SensorSettings = { hertz: 0, width: 640, height: 480, isFront: false };
const DEFAULT_HERTZ = { imu: 50, gps: 0, camera: 5, battery: 0 };

export class PhoneSensor {
  readonly sensor: Sensor;
  readonly settings: Signal<SensorSettings>;
  readonly isOn = signal(false);
  readonly problem: Signal<Problem | undefined> = signal(undefined);
  readonly rate = new RateMeter();
  private readonly encode: (message: unknown) => Uint8Array;
  private end: (() => void) | undefined;
  private run = 0;
  private channel: number | undefined;

  constructor(sensor: Sensor) {
    this.sensor = sensor;
    this.encode = encoder(phoneType(sensor.type));
    const key = `phone.${sensor.id}`;
    this.settings = signal(loadSetting(key, { ...DEFAULTS, hertz: DEFAULT_HERTZ[sensor.id] }));
  }

  get topic(): string {
    return `/${phoneName.value}/${this.sensor.topic}`;
  }

  change(settings: Partial<SensorSettings>): void {
    this.settings.value = { ...this.settings.value, ...settings };
    saveSetting(`phone.${this.sensor.id}`, this.settings.value);
    if (this.isOn.peek() && link) {
      this.stop();
      void this.begin(link);
    }
  }

  /** Switches the sensor on or off. Must be called in a tap's event, because browsers ask for permission only then. */
  toggle(): void {
    this.isOn.value = !this.isOn.value;
    this.problem.value = undefined;
    updateSensors();
  }

  async begin(link: PhoneLink): Promise<void> {
    const run = ++this.run;
    const frame = this.sensor.id === "camera" ? `${phoneName.peek()}_camera` : phoneName.peek();
    const channel = link.open(this.topic, this.sensor.type);
    this.channel = channel;
    const fail = (problem: Problem) => {
      if (run !== this.run) return;
      this.problem.value = problem;
      this.isOn.value = false;
      updateSensors();
    };
    try {
      const end = await this.sensor.start({
        settings: this.settings.peek(),
        hasRoom: () => link.hasRoom,
        publish: (fields, measuredMs) => {
          const stamp = link.stamp(measuredMs);
          if (run !== this.run || !stamp) return;
          const payload = this.encode({ header: { stamp, frame_id: frame }, ...fields });
          if (link.publish(channel, payload)) this.rate.add(performance.now(), payload.length);
        },
        fail,
      });
      if (run === this.run) this.end = end;
      else end();
    } catch (error) {
      fail(error instanceof SensorError ? error.problem : { text: String(error) });
    }
  }

  stop(): void {
    this.run++;
    this.end?.();
    this.end = undefined;
    this.rate.clear();
    if (this.channel !== undefined) link?.end(this.channel);
    this.channel = undefined;
  }

  get isRunning(): boolean {
    return this.channel !== undefined;
  }
}

export const sensors: readonly PhoneSensor[] = [imu, gps, camera, battery].map(
  (each) => new PhoneSensor(each),
);

/** The first part of all topics, and the frame of the messages. */
export const phoneName: Signal<string> = signal(loadSetting("phone.name", newDeviceName("phone")));
saveSetting("phone.name", phoneName.peek());

/** The connection while a sensor is on and the page is visible. */
export const phoneLink: Signal<PhoneLink | undefined> = signal(undefined);
let link: PhoneLink | undefined;

/** Renames the topics; sensors that are on start again. */
export function renamePhone(name: string): void {
  phoneName.value = name;
  saveSetting("phone.name", name);
  stopAll();
  updateSensors();
}

/** Starts the sensors that are on, and stops the others; while the page is hidden, all are stopped. */
function updateSensors(): void {
  const wanted = pageHidden.peek() ? [] : sensors.filter((each) => each.isOn.peek());
  for (const each of sensors) if (!wanted.includes(each) && each.isRunning) each.stop();
  if (wanted.length === 0) {
    link?.close();
    link = undefined;
  } else {
    link ??= new PhoneLink();
    for (const each of wanted) if (!each.isRunning) void each.begin(link);
  }
  phoneLink.value = link;
}

function stopAll(): void {
  for (const each of sensors) if (each.isRunning) each.stop();
}

effect(() => {
  void pageHidden.value;
  updateSensors();
});
