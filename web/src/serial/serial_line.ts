// One open serial port: reads until it is lost, writes in order, resets the board by DTR.
import type { SerialPort } from "./web_serial.ts";

// The default of 255 bytes is only 20 ms of a fast line.
const BUFFER_BYTES = 16 * 1024;
// An Arduino is reset through a capacitor when DTR is asserted again.
const RESET_MS = 100;

export interface LineHandlers {
  /** Bytes of the board; reading continues when the promise resolves. */
  onData(data: Uint8Array<ArrayBuffer>): Promise<void> | undefined;
  /** The board was unplugged, or the port failed. */
  onLost(): void;
}

export class SerialLine {
  private readonly port: SerialPort;
  private readonly handlers: LineHandlers;
  private reader: ReadableStreamDefaultReader<Uint8Array<ArrayBuffer>> | undefined;
  private writer: WritableStreamDefaultWriter<Uint8Array<ArrayBuffer>> | undefined;
  private writing: Promise<void> = Promise.resolve();
  private reading: Promise<void> = Promise.resolve();
  private isClosed = false;

  constructor(port: SerialPort, handlers: LineHandlers) {
    this.port = port;
    this.handlers = handlers;
  }

  /** Opens the port and resets the board. Rejects when another program has the port. */
  async open(baud: number): Promise<void> {
    await this.port.open({ baudRate: baud, bufferSize: BUFFER_BYTES });
    this.writer = this.port.writable?.getWriter();
    await this.reset();
    this.reading = this.read();
  }

  /** Writes after earlier bytes; `onWritten` is called when the port has accepted them. */
  write(data: Uint8Array<ArrayBuffer>, onWritten: () => void): void {
    this.writing = this.writing.then(async () => {
      try {
        await this.writer?.write(data);
      } catch {
        // The reading side notices that the port is lost.
        return;
      }
      onWritten();
    });
  }

  /** Resets the board as a serial monitor does, where its DTR line is wired for that. */
  async reset(): Promise<void> {
    try {
      await this.port.setSignals({ dataTerminalReady: false, requestToSend: false });
      await new Promise((resolve) => setTimeout(resolve, RESET_MS));
      await this.port.setSignals({ dataTerminalReady: true, requestToSend: true });
    } catch {
      // Some adapters have no such lines.
    }
  }

  async close(): Promise<void> {
    this.isClosed = true;
    // Each may fail when the board is unplugged.
    const quietly = (work: Promise<unknown> | undefined) => work?.catch(() => undefined);
    await quietly(this.reader?.cancel());
    await this.reading;
    await quietly(this.writer?.abort());
    this.writer?.releaseLock();
    await quietly(this.port.close());
  }

  private async read(): Promise<void> {
    // After a framing error or an overrun, the port has a new stream; after a loss, it has none.
    while (this.port.readable && !this.isClosed) {
      this.reader = this.port.readable.getReader();
      try {
        for (;;) {
          const { value, done } = await this.reader.read();
          if (done) break;
          await this.handlers.onData(value);
        }
      } catch {
        // The condition of the loop decides whether reading continues.
      } finally {
        this.reader.releaseLock();
        this.reader = undefined;
      }
    }
    if (!this.isClosed) this.handlers.onLost();
  }
}
