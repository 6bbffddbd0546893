// The page's two connections to the gateway: one to view, one for commands, so that a camera never delays a stop.
import { gatewayUrl } from "./address.ts";
import { gatewaySocket } from "./gateway_socket.ts";
import {
  type Channel,
  type ClientChannel,
  type GraphUpdate,
  type Lease,
  messageData,
  type Parameter,
  type Recordings,
  type ServerBinary,
  type ServerInfo,
  type ServerText,
  type Service,
  type Status,
  serviceRequest,
} from "./protocol.ts";
import type { ReconnectingSocket } from "./socket.ts";

export interface GatewayHandlers {
  /** The view connection is open (`info`) or lost (undefined). */
  onConnection(info: ServerInfo | undefined, reason: string): void;
  onCommandConnection(isOpen: boolean): void;
  onChannels(added: Channel[], removedIds: number[]): void;
  onServices(added: Service[], removedIds: number[]): void;
  onMessage(subscriptionId: number, timeNs: bigint, payload: Uint8Array): void;
  onGraph(update: GraphUpdate): void;
  onParameters(parameters: Parameter[]): void;
  onStatus(status: Status): void;
  onStatusRemoved(ids: string[]): void;
  /** The gateway has refused a command. */
  onRefusal(reason: string): void;
  onTime(timeNs: bigint): void;
  onRecordings(recordings: Recordings): void;
}

interface Waiting<T> {
  resolve(value: T): void;
  reject(error: Error): void;
}

// A request without an answer must not be kept forever; the gateway itself waits 60 s for a service.
const ANSWER_TIMEOUT_MS = 65_000;

/** A request that the gateway refused, or that it did not answer. */
export class GatewayError extends Error {}

export class Gateway {
  private readonly view: ReconnectingSocket;
  private readonly command: ReconnectingSocket;
  private readonly handlers: GatewayHandlers;
  private info: ServerInfo | undefined;
  private readonly commandServices = new Map<string, Service>();
  private readonly calls = new Map<number, Waiting<Uint8Array>>();
  private readonly parameterRequests = new Map<string, Waiting<Parameter[]>>();
  private readonly assets = new Map<number, Waiting<Uint8Array>>();
  private readonly advertised = new Map<number, ClientChannel>();
  private readonly leases = new Map<number, (lease: Lease) => void>();
  private readonly watched = new Set<string>();
  private followsRecordings = false;
  private isCommandOpen = false;
  private mayPublish = true;
  private nextId = 1;

  constructor(handlers: GatewayHandlers) {
    this.handlers = handlers;
    this.view = gatewaySocket(gatewayUrl, {
      onOpen: () => {
        this.view.send({ op: "subscribeConnectionGraph" });
        handlers.onConnection(this.info, "");
      },
      onText: (message) => this.onViewText(message),
      onBinary: (message) => this.onViewBinary(message),
      onClose: (reason) => {
        rejectAll(this.assets);
        handlers.onConnection(undefined, reason);
      },
    });
    this.command = gatewaySocket(gatewayUrl, {
      onOpen: () => {
        this.isCommandOpen = true;
        for (const [id, each] of this.advertised) this.sendAdvertise(id, each);
        if (this.watched.size > 0) {
          this.command.send({ op: "subscribeParameterUpdates", parameterNames: [...this.watched] });
        }
        if (this.followsRecordings) this.command.send({ op: "listRecordings" });
        handlers.onCommandConnection(true);
      },
      onText: (message) => this.onCommandText(message),
      onBinary: (message) => this.onCommandBinary(message),
      onClose: () => {
        this.isCommandOpen = false;
        this.commandServices.clear();
        rejectAll(this.calls);
        rejectAll(this.parameterRequests);
        handlers.onCommandConnection(false);
      },
      // Only this connection is watched: on the other one, a large message may take a long time to arrive.
      onSilence: () => this.view.drop(),
    });
  }

  subscribe(subscriptions: { id: number; channelId: number }[]): void {
    this.view.send({ op: "subscribe", subscriptions });
  }

  unsubscribe(subscriptionIds: number[]): void {
    this.view.send({ op: "unsubscribe", subscriptionIds });
  }

  /** Advertises a topic; returns the id for `publish`. It is advertised again after a reconnection. */
  advertise(topic: string, schemaName: string, schema: string): number {
    const id = this.nextId++;
    const channel = { topic, schemaName, schema };
    this.advertised.set(id, channel);
    this.sendAdvertise(id, channel);
    return id;
  }

  /**
   * Advertises a command topic under a lease of the gateway: one client drives at a time, and a command that is not
   * repeated within 125 ms is followed by a zero. `driver` is the name that other users see.
   */
  advertiseDriven(
    channel: Omit<ClientChannel, "driver">,
    driver: string,
    onLease: (lease: Lease) => void,
  ): number {
    const id = this.nextId++;
    const driven = { ...channel, driver };
    this.advertised.set(id, driven);
    this.leases.set(id, onLease);
    this.sendAdvertise(id, driven);
    return id;
  }

  unadvertise(id: number): void {
    this.leases.delete(id);
    if (!this.advertised.delete(id) || !this.isCommandOpen || !this.mayPublish) return;
    this.command.send({ op: "unadvertise", channelIds: [id] });
  }

  /** Publishes on an advertised topic; false without a connection: the message is then dropped. */
  publish(id: number, payload: Uint8Array): boolean {
    return this.command.send(messageData(id, payload));
  }

  /** Calls a service; resolves with the encoded response. */
  call(name: string, request: Uint8Array): Promise<Uint8Array> {
    const service = this.commandServices.get(name);
    if (!service) return Promise.reject(new GatewayError(`${name} is not offered`));
    const id = this.nextId++;
    return wait(this.calls, id, () => this.command.send(serviceRequest(service.id, id, request)));
  }

  /** Reads parameters; no names means all. */
  getParameters(names: string[] = []): Promise<Parameter[]> {
    const id = String(this.nextId++);
    return wait(this.parameterRequests, id, () =>
      this.command.send({ op: "getParameters", parameterNames: names, id }),
    );
  }

  /** Sets parameters; resolves with their new values. */
  setParameters(parameters: Parameter[]): Promise<Parameter[]> {
    const id = String(this.nextId++);
    return wait(this.parameterRequests, id, () => this.command.send({ op: "setParameters", parameters, id }));
  }

  /** Reports changes of these parameters to `onParameters` from now on. */
  watchParameters(names: string[]): void {
    for (const each of names) this.watched.add(each);
    this.command.send({ op: "subscribeParameterUpdates", parameterNames: names });
  }

  /** Reports recordings to `onRecordings`, now, at every change and after a reconnection. */
  followRecordings(): void {
    this.followsRecordings = true;
    this.command.send({ op: "listRecordings" });
  }

  /** Begins a recording; no topics means all. */
  startRecording(topics: string[], format: "bag" | "mcap"): void {
    this.command.send({ op: "startRecording", topics, format });
  }

  stopRecording(): void {
    this.command.send({ op: "stopRecording" });
  }

  /** Plays a recording from a time in it, in seconds; below `/playback` unless its topics keep their names. */
  playRecording(name: string, start: number, rate: number, prefixed: boolean): void {
    this.command.send({ op: "playRecording", name, start, rate, prefixed });
  }

  pausePlayback(paused: boolean): void {
    this.command.send({ op: "pausePlayback", paused });
  }

  stopPlayback(): void {
    this.command.send({ op: "stopPlayback" });
  }

  /** Fetches a file of the robot, such as `package://arm/meshes/base.stl`. */
  fetchAsset(uri: string): Promise<Uint8Array> {
    const requestId = this.nextId++;
    return wait(this.assets, requestId, () => this.view.send({ op: "fetchAsset", uri, requestId }));
  }

  close(): void {
    this.view.close();
    this.command.close();
  }

  private sendAdvertise(id: number, channel: ClientChannel): void {
    // A connection that opens later advertises all topics; a page that may only view would be refused.
    if (!this.isCommandOpen || !this.mayPublish) return;
    const described = { id, encoding: "ros1", schemaEncoding: "ros1msg", ...channel };
    this.command.send({ op: "advertise", channels: [described] });
  }

  private onViewText(message: ServerText): void {
    switch (message.op) {
      case "serverInfo":
        this.info = message;
        break;
      case "advertise":
        this.handlers.onChannels(message.channels, []);
        break;
      case "unadvertise":
        this.handlers.onChannels([], message.channelIds);
        break;
      case "advertiseServices":
        this.handlers.onServices(message.services, []);
        break;
      case "unadvertiseServices":
        this.handlers.onServices([], message.serviceIds);
        break;
      case "connectionGraphUpdate":
        this.handlers.onGraph(message);
        break;
      case "status":
        this.handlers.onStatus(message);
        break;
      case "removeStatus":
        this.handlers.onStatusRemoved(message.statusIds);
        break;
    }
  }

  private onViewBinary(message: ServerBinary): void {
    if (message.op === "message") {
      this.handlers.onMessage(message.subscriptionId, message.timeNs, message.payload);
    } else if (message.op === "time") this.handlers.onTime(message.timeNs);
    else if (message.op === "asset") {
      const waiting = this.assets.get(message.requestId);
      if (message.data) waiting?.resolve(message.data);
      else waiting?.reject(new GatewayError(message.error));
    }
  }

  private onCommandText(message: ServerText): void {
    switch (message.op) {
      case "serverInfo":
        this.mayPublish = message.metadata?.rights !== "view";
        break;
      case "advertiseServices":
        for (const each of message.services) this.commandServices.set(each.name, each);
        break;
      case "unadvertiseServices":
        for (const [name, each] of this.commandServices) {
          if (message.serviceIds.includes(each.id)) this.commandServices.delete(name);
        }
        break;
      case "recordings":
        this.handlers.onRecordings(message);
        break;
      case "drive":
        this.leases.get(message.channelId)?.({ state: message.state, driver: message.driver });
        break;
      case "serviceCallFailure":
        this.calls.get(message.callId)?.reject(new GatewayError(message.message));
        break;
      case "parameterValues":
        if (message.id !== undefined) this.parameterRequests.get(message.id)?.resolve(message.parameters);
        this.handlers.onParameters(message.parameters);
        break;
      case "status":
        // Statuses with an id also arrive on the view connection; the others answer requests of this one.
        if (message.id === undefined) this.handlers.onRefusal(message.message);
        break;
    }
  }

  private onCommandBinary(message: ServerBinary): void {
    if (message.op === "serviceResponse") this.calls.get(message.callId)?.resolve(message.payload);
  }
}

function wait<K, T>(waiting: Map<K, Waiting<T>>, id: K, send: () => boolean): Promise<T> {
  return new Promise<T>((resolve, reject) => {
    if (!send()) {
      reject(new GatewayError("there is no connection to the robot"));
      return;
    }
    const end = () => {
      clearTimeout(timer);
      waiting.delete(id);
    };
    const timer = setTimeout(() => {
      end();
      reject(new GatewayError("the robot did not answer"));
    }, ANSWER_TIMEOUT_MS);
    waiting.set(id, {
      resolve(value) {
        end();
        resolve(value);
      },
      reject(error) {
        end();
        reject(error);
      },
    });
  });
}

function rejectAll<K, T>(waiting: Map<K, Waiting<T>>): void {
  for (const each of [...waiting.values()]) each.reject(new GatewayError("the connection was lost"));
}
