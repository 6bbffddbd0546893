// navigator.serial with one port, whose bytes pass through a WebSocket: the test is its board. `boardUrl` is given.
{
  class Port extends EventTarget {
    readable = null;
    writable = null;

    getInfo() {
      return { usbVendorId: 0x2341, usbProductId: 0x43 };
    }

    async open({ baudRate }) {
      const socket = new WebSocket(`${boardUrl}?baud=${baudRate}`);
      socket.binaryType = "arraybuffer";
      await new Promise((resolve, reject) => {
        socket.onopen = resolve;
        socket.onerror = () => reject(new DOMException("Failed to open serial port.", "NetworkError"));
      });
      this.socket = socket;
      this.readable = new ReadableStream({
        start: (controller) => {
          socket.onmessage = ({ data }) => controller.enqueue(new Uint8Array(data));
          socket.onclose = () => {
            this.readable = this.writable = null;
            controller.error(new DOMException("The device has been lost.", "NetworkError"));
          };
        },
      });
      this.writable = new WritableStream({ write: (data) => socket.send(data) });
    }

    async setSignals(signals) {
      this.socket.send(JSON.stringify(signals));
    }

    async close() {
      this.readable = this.writable = null;
      this.socket.onclose = null;
      this.socket.close();
    }
  }
  const port = new Port();
  let isAllowed = false;
  const serial = new EventTarget();
  serial.getPorts = async () => (isAllowed ? [port] : []);
  serial.requestPort = async () => {
    isAllowed = true;
    return port;
  };
  Object.defineProperty(navigator, "serial", { value: serial, configurable: true });
}
