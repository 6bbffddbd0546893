// The part of the Web Serial API that the page uses. Source: https://wicg.github.io/serial/

export interface PortInfo {
  usbVendorId?: number;
  usbProductId?: number;
}

export interface SerialPort extends EventTarget {
  readonly readable: ReadableStream<Uint8Array<ArrayBuffer>> | null;
  readonly writable: WritableStream<Uint8Array<ArrayBuffer>> | null;
  open(options: { baudRate: number; bufferSize?: number }): Promise<void>;
  close(): Promise<void>;
  setSignals(signals: { dataTerminalReady?: boolean; requestToSend?: boolean }): Promise<void>;
  getInfo(): PortInfo;
}

export interface Serial extends EventTarget {
  getPorts(): Promise<SerialPort[]>;
  /** Lets the user choose a port; rejects when none was chosen. */
  requestPort(): Promise<SerialPort>;
}

/** The browser's serial ports; undefined without support, or if the page is neither on https nor on localhost. */
export function serialPorts(): Serial | undefined {
  return (navigator as Navigator & { serial?: Serial }).serial;
}
