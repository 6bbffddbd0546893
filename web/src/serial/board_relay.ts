// Relays one serial port of this device to the robot, which serves the board like any other.
import { effect, type Signal, signal } from "@preact/signals";
import { serialUrl } from "../connection/address.ts";
import { ReconnectingSocket } from "../connection/socket.ts";
import { pageHidden } from "../store/visibility.ts";
import { SerialLine } from "./serial_line.ts";
import type { SerialPort } from "./web_serial.ts";

/** `away`: the robot does not accept the board now, `hidden`: the page is hidden, `unplugged`: the port is lost. */
export type RelayState = "opening" | "connected" | "away" | "hidden" | "unplugged";

// The robot disconnects a page that reports nothing for 4 s.
const REPORT_MS = 1000;
// Further bytes wait in the serial port, whose buffer may then overflow, as on any slow host.
const MAX_WAITING_BYTES = 64 * 1024;
const ROOM_POLL_MS = 20;

export class BoardRelay {
  readonly port: SerialPort;
  readonly name: string;
  readonly baud: number;
  readonly state: Signal<RelayState> = signal("opening");
  /** Why the board is not connected, as a text of the robot or the browser; may be empty. */
  readonly problem = signal("");
  /** Bytes from the board and to it, since the start. */
  receivedBytes = 0;
  sentBytes = 0;
  // The robot recognizes the board by this key after a reconnection.
  private readonly key = crypto.randomUUID();
  private line: SerialLine | undefined;
  private socket: ReconnectingSocket | undefined;
  private isConnected = false;
  private isEnded = false;
  private writtenBytes = 0;
  private connection = 0;
  private reports: ReturnType<typeof setInterval> | undefined;
  private readonly endWatching: () => void;

  constructor(port: SerialPort, name: string, baud: number) {
    this.port = port;
    this.name = name;
    this.baud = baud;
    this.endWatching = effect(() => {
      if (pageHidden.value) this.leave("hidden");
      else if (this.line) this.join();
    });
  }

  /** Opens the port, then connects. Rejects with the browser's reason when the port cannot be opened. */
  async open(): Promise<void> {
    const line = new SerialLine(this.port, {
      onData: (data) => this.relay(data),
      onLost: () => this.lose(line),
    });
    await line.open(this.baud);
    this.line = line;
    if (this.isEnded) await this.close();
    else if (pageHidden.peek()) this.state.value = "hidden";
    else this.join();
  }

  reset(): void {
    void this.line?.reset();
  }

  async close(): Promise<void> {
    this.isEnded = true;
    this.endWatching();
    this.leave("away");
    const { line } = this;
    this.line = undefined;
    await line?.close();
  }

  private join(): void {
    if (this.socket) return;
    this.state.value = "opening";
    this.socket = new ReconnectingSocket(serialUrl, [], {
      onStart: () => {
        this.socket?.send({ op: "connect", name: this.name, key: this.key, baud: this.baud });
      },
      onMessage: (data) => this.receive(data),
      onClose: (reason) => {
        this.endConnection();
        this.state.value = "away";
        this.problem.value = reason;
      },
    });
  }

  private leave(state: RelayState): void {
    this.endConnection();
    this.socket?.close();
    this.socket = undefined;
    this.state.value = state;
  }

  private endConnection(): void {
    this.isConnected = false;
    this.connection++;
    clearInterval(this.reports);
  }

  private lose(line: SerialLine): void {
    this.leave("unplugged");
    this.line = undefined;
    void line.close();
  }

  private receive(data: string | ArrayBuffer): boolean {
    if (typeof data === "string") {
      // The robot's only text: it has accepted the board.
      this.isConnected = true;
      this.writtenBytes = 0;
      this.state.value = "connected";
      this.problem.value = "";
      this.reports = setInterval(() => this.report(), REPORT_MS);
      return true;
    }
    const connection = this.connection;
    this.line?.write(new Uint8Array(data), () => {
      this.sentBytes += data.byteLength;
      if (connection !== this.connection) return;
      this.writtenBytes += data.byteLength;
      this.report();
    });
    return false;
  }

  private report(): void {
    this.socket?.send({ op: "written", bytes: this.writtenBytes });
  }

  private relay(data: Uint8Array<ArrayBuffer>): Promise<void> | undefined {
    this.receivedBytes += data.byteLength;
    // Earlier bytes are lost, as before a serial port is opened.
    if (!this.isConnected) return;
    this.socket?.send(data);
    if (this.hasRoom()) return;
    return new Promise((resolve) => {
      const timer = setInterval(() => {
        if (!this.hasRoom()) return;
        clearInterval(timer);
        resolve();
      }, ROOM_POLL_MS);
    });
  }

  private hasRoom(): boolean {
    return !this.isConnected || (this.socket?.waitingBytes ?? 0) < MAX_WAITING_BYTES;
  }
}
