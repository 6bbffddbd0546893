// One WebSocket that reconnects automatically, sooner when the page becomes visible.

import { stringifyExact } from "./exact_json.ts";

// A gateway that restarts is back within a second; one that is switched off must not be asked often.
const FIRST_RETRY_MS = 250;
const MAX_RETRY_MS = 5000;
// A server that accepts the connection must answer within this time.
const OPEN_TIMEOUT_MS = 10_000;
// Browsers do not report a network that has failed. When nothing has arrived for one to two of these periods, the
// socket sends a probe; after two more without an answer, the connection has failed.
const QUIET_MS = 5000;

export interface SocketHandlers {
  /** The WebSocket is open; if the protocol begins with a message of the client, this sends it. */
  onStart?(): void;
  /** A message; returns whether the connection can be used from now on. */
  onMessage(data: string | ArrayBuffer): boolean;
  /** The connection was closed, for example with the server's reason; the socket connects again later. */
  onClose(reason: string): void;
  /** A request that the server answers immediately, to find out whether the network has failed. */
  probe?: object;
  /** The probe was not answered; the connection is closed next. */
  onSilence?(): void;
}

export class ReconnectingSocket {
  private readonly url: () => string;
  private readonly protocols: string[];
  private readonly handlers: SocketHandlers;
  private socket: WebSocket | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private watch: ReturnType<typeof setInterval> | undefined;
  private quietPeriods = 0;
  private retryMs = FIRST_RETRY_MS;
  private isClosed = false;

  constructor(url: () => string, protocols: string[], handlers: SocketHandlers) {
    this.url = url;
    this.protocols = protocols;
    this.handlers = handlers;
    addEventListener("online", this.retryNow);
    document.addEventListener("visibilitychange", this.retryNow);
    this.connect();
  }

  /** Sends a message; false when there is no connection. */
  send(message: object | Uint8Array<ArrayBuffer>): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(message instanceof Uint8Array ? message : stringifyExact(message));
    return true;
  }

  /** Bytes that wait to be sent. */
  get waitingBytes(): number {
    return this.socket?.bufferedAmount ?? 0;
  }

  /** Closes the connection without waiting for the server, if the network has failed. */
  drop(): void {
    if (!this.socket) return;
    clearInterval(this.watch);
    const socket = this.socket;
    this.socket = undefined;
    socket.close();
    this.retryLater("");
  }

  close(): void {
    this.isClosed = true;
    clearTimeout(this.timer);
    clearInterval(this.watch);
    removeEventListener("online", this.retryNow);
    document.removeEventListener("visibilitychange", this.retryNow);
    this.socket?.close();
  }

  private readonly retryNow = () => {
    if (document.hidden || this.timer === undefined || this.isClosed) return;
    clearTimeout(this.timer);
    this.connect();
  };

  private connect(): void {
    this.timer = undefined;
    let socket: WebSocket;
    try {
      socket = new WebSocket(this.url(), this.protocols);
    } catch (error) {
      this.retryLater(String(error));
      return;
    }
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    const timeout = setTimeout(() => socket.close(), OPEN_TIMEOUT_MS);
    socket.onopen = () => {
      if (this.socket === socket) this.handlers.onStart?.();
    };
    socket.onmessage = (event) => {
      if (this.socket !== socket || this.isClosed) return;
      this.quietPeriods = 0;
      if (!this.handlers.onMessage(event.data as string | ArrayBuffer)) return;
      clearTimeout(timeout);
      this.retryMs = FIRST_RETRY_MS;
      clearInterval(this.watch);
      if (this.handlers.probe) this.watch = setInterval(this.checkSilence, QUIET_MS);
    };
    socket.onclose = (event) => {
      clearTimeout(timeout);
      if (this.socket !== socket) return;
      clearInterval(this.watch);
      this.socket = undefined;
      if (!this.isClosed) this.retryLater(event.reason);
    };
  }

  private readonly checkSilence = () => {
    this.quietPeriods++;
    if (this.quietPeriods === 2) this.send(this.handlers.probe as object);
    else if (this.quietPeriods === 4) {
      this.handlers.onSilence?.();
      this.drop();
    }
  };

  private retryLater(reason: string): void {
    // Many pages must not connect again at the same moment.
    const wait = this.retryMs * (0.75 + Math.random() / 2);
    this.retryMs = Math.min(this.retryMs * 2, MAX_RETRY_MS);
    this.timer = setTimeout(() => this.connect(), wait);
    this.handlers.onClose(reason);
  }
}
