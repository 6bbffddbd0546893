// The boards that this page relays; they stay connected while other panels are shown.
import { effect, type Signal, signal } from "@preact/signals";
import { newDeviceName } from "../store/device_name.ts";
import { loadSetting, saveSetting } from "../store/storage.ts";
import { pageHidden } from "../store/visibility.ts";
import { BoardRelay } from "./board_relay.ts";
import { type SerialPort, serialPorts } from "./web_serial.ts";

export const BAUDS = [9600, 19200, 38400, 57600, 115200, 230400, 250000, 500000, 1000000, 2000000] as const;
const DEFAULT_BAUD = 57600;

/** The settings of a kind of board on this device. */
export interface BoardSettings {
  name: string;
  baud: number;
}

export const relays: Signal<readonly BoardRelay[]> = signal([]);

/** The last settings of this kind of board; for a new kind, a new name and the usual baud rate. */
export function boardSettings(port: SerialPort): BoardSettings {
  const known = loadSetting<BoardSettings | undefined>(settingsKey(port), undefined);
  if (known) return known;
  const settings = { name: newDeviceName("board"), baud: DEFAULT_BAUD };
  saveSetting(settingsKey(port), settings);
  return settings;
}

/** Relays a port until `disconnectBoard`. Rejects with the browser's reason when it cannot be opened. */
export async function connectBoard(port: SerialPort, settings: BoardSettings): Promise<void> {
  saveSetting(settingsKey(port), settings);
  const relay = new BoardRelay(port, settings.name, settings.baud);
  relays.value = [...relays.value, relay];
  try {
    await relay.open();
  } catch (error) {
    await disconnectBoard(relay);
    throw error;
  }
}

export async function disconnectBoard(relay: BoardRelay): Promise<void> {
  relays.value = relays.value.filter((each) => each !== relay);
  await relay.close();
}

/** Opens the ports of boards that were unplugged and are back. */
async function reopenBoards(): Promise<void> {
  const ports = (await serialPorts()?.getPorts()) ?? [];
  for (const relay of relays.value.filter((each) => each.state.peek() === "unplugged")) {
    const used = relays.value.filter((each) => each !== relay).map((each) => each.port);
    const port = ports.find((each) => !used.includes(each) && settingsKey(each) === settingsKey(relay.port));
    if (!port) continue;
    await disconnectBoard(relay);
    await connectBoard(port, { name: relay.name, baud: relay.baud }).catch((error: unknown) =>
      console.warn(error),
    );
  }
}

serialPorts()?.addEventListener("connect", () => void reopenBoards());

// The screen stays on while a board is connected: a phone that sleeps hides the page.
effect(() => {
  if (relays.value.length === 0 || pageHidden.value || !("wakeLock" in navigator)) return;
  let isOver = false;
  let lock: WakeLockSentinel | undefined;
  navigator.wakeLock.request("screen").then(
    (found) => {
      if (isOver) void found.release();
      else lock = found;
    },
    // The browser refuses this when the battery is low; the board stays connected while the user looks at the page.
    () => undefined,
  );
  return () => {
    isOver = true;
    void lock?.release();
  };
});

function settingsKey(port: SerialPort): string {
  const { usbVendorId = 0, usbProductId = 0 } = port.getInfo();
  return `board.${usbVendorId.toString(16)}.${usbProductId.toString(16)}`;
}
