// The battery as sensor_msgs/BatteryState. Source: https://www.w3.org/TR/battery-status/
import { pageTimeMs } from "./clock_offset.ts";
import { type Sensor, SensorError } from "./sensor.ts";

const CHARGING = 1;
const DISCHARGING = 2;
const FULL = 4;
const PERIOD_MS = 1000;

interface BatteryManager {
  readonly charging: boolean;
  readonly level: number;
}

export const battery: Sensor = {
  id: "battery",
  type: "sensor_msgs/BatteryState",
  topic: "battery",
  async start(output) {
    const { getBattery } = navigator as Navigator & { getBattery?: () => Promise<BatteryManager> };
    if (!getBattery) throw new SensorError("missing");
    const manager = await getBattery.call(navigator);
    const publish = () => {
      const { level, charging } = manager;
      output.publish(
        {
          voltage: Number.NaN,
          temperature: Number.NaN,
          current: Number.NaN,
          charge: Number.NaN,
          capacity: Number.NaN,
          design_capacity: Number.NaN,
          percentage: level,
          power_supply_status: charging ? (level === 1 ? FULL : CHARGING) : DISCHARGING,
          present: true,
        },
        pageTimeMs(),
      );
    };
    publish();
    const timer = setInterval(publish, PERIOD_MS);
    return () => clearInterval(timer);
  },
};
