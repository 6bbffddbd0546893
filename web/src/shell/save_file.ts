// Saves data as a file on the user's computer.

export function saveFile(name: string, data: BlobPart | BlobPart[], type: string): void {
  const url = URL.createObjectURL(new Blob([data].flat(), { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  // Until then, the browser has read the data.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
