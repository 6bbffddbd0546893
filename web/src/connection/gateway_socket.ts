// A connection to the gateway that reconnects automatically, and parses the gateway's messages.
import { parseExact } from "./exact_json.ts";
import { parseBinary, type ServerBinary, type ServerText, SUBPROTOCOL } from "./protocol.ts";
import { ReconnectingSocket } from "./socket.ts";

// The beginning of a message with parameters, as the gateway writes it.
const PARAMETERS = '{"op":"parameterValues"';

export interface GatewaySocketHandlers {
  /** The server's first message has arrived: the connection can be used. */
  onOpen(): void;
  onText(message: ServerText): void;
  onBinary(message: ServerBinary): void;
  onClose(reason: string): void;
  /** The gateway does not answer: the network has failed. The connection is closed next. */
  onSilence?(): void;
}

export function gatewaySocket(url: () => string, handlers: GatewaySocketHandlers): ReconnectingSocket {
  return new ReconnectingSocket(url, [SUBPROTOCOL], {
    onMessage(data) {
      if (typeof data !== "string") {
        const message = parseBinary(data);
        if (message) handlers.onBinary(message);
        return false;
      }
      let message: ServerText;
      try {
        // Only parameters have integers of 64 bits; the others are parsed faster.
        const parse = data.startsWith(PARAMETERS) ? parseExact : JSON.parse;
        message = parse(data) as ServerText;
      } catch {
        return false;
      }
      handlers.onText(message);
      if (message.op !== "serverInfo") return false;
      handlers.onOpen();
      return true;
    },
    onClose: handlers.onClose,
    ...(handlers.onSilence && { probe: { op: "askTime", id: 0 }, onSilence: handlers.onSilence }),
  });
}
