// Names of devices that this page connects: boards, and the device that shows the page.

const NAME = /^[A-Za-z][A-Za-z0-9_]{0,39}$/;

/** Whether a name can be a part of topic names, and is short enough to read. */
export function isDeviceName(name: string): boolean {
  return NAME.test(name);
}

/** A name that ends with random digits, so that two devices rarely have the same. */
export function newDeviceName(kind: string): string {
  const random = crypto.getRandomValues(new Uint16Array(1))[0]!;
  return `${kind}_${random.toString(16).padStart(4, "0")}`;
}
