// Draws the newest image of a topic on a canvas; images that arrive while one is decoded are dropped.

import type { Feed } from "../../store/feed.ts";
import { frameTask } from "../../store/frames.ts";
import { decodeDepth, isCompressedDepth } from "./compressed_depth.ts";
import { decodeGray16 } from "./gray_png.ts";
import { type RawImage, toRgba } from "./raw_image.ts";

export interface Turn {
  /** Quarter turns clockwise. */
  quarters: number;
  mirrored: boolean;
}

export class ImageView {
  readonly canvas = document.createElement("canvas");
  turn: Turn = { quarters: 0, mirrored: false };
  private readonly feed: Feed;
  private readonly report: (problem: string) => void;
  private readonly frame = frameTask(() => void this.show());
  private bitmap: ImageBitmap | undefined;
  private isDecoding = false;
  private isOld = false;
  private isDisposed = false;

  /** `report` gets a sentence when the newest image cannot be shown, and "" when it can. */
  constructor(feed: Feed, report: (problem: string) => void) {
    this.feed = feed;
    this.report = report;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", feed.topicName);
  }

  /** A new image has arrived. */
  update(): void {
    this.isOld = true;
    this.frame.markDirty();
  }

  /** Draws the current image again, after a change of `turn`. */
  redraw(): void {
    if (this.bitmap === undefined) return;
    const { quarters, mirrored } = this.turn;
    const { width, height } = this.bitmap;
    const isUpright = quarters % 2 === 0;
    this.canvas.width = isUpright ? width : height;
    this.canvas.height = isUpright ? height : width;
    const context = this.canvas.getContext("2d") as CanvasRenderingContext2D;
    context.translate(this.canvas.width / 2, this.canvas.height / 2);
    context.rotate((quarters * Math.PI) / 2);
    if (mirrored) context.scale(-1, 1);
    context.drawImage(this.bitmap, -width / 2, -height / 2);
  }

  dispose(): void {
    this.isDisposed = true;
    this.frame.dispose();
    this.bitmap?.close();
    this.canvas.remove();
  }

  private async show(): Promise<void> {
    if (this.isDecoding || !this.isOld) return;
    this.isOld = false;
    this.isDecoding = true;
    try {
      const bitmap = await this.decode();
      if (this.isDisposed) {
        bitmap?.close();
        return;
      }
      if (bitmap !== undefined) {
        this.bitmap?.close();
        this.bitmap = bitmap;
        this.redraw();
        this.report("");
      }
    } catch (error) {
      this.report((error as Error).message);
    } finally {
      this.isDecoding = false;
    }
    if (this.isOld) this.frame.markDirty();
  }

  private async decode(): Promise<ImageBitmap | undefined> {
    const message = this.feed.lastMessage();
    if (message === undefined) return undefined;
    if (message instanceof Error) throw message;
    if ("encoding" in message) return bitmapOf(message as unknown as RawImage);
    const { format, data } = message as unknown as { format: string; data: Uint8Array<ArrayBuffer> };
    if (isCompressedDepth(format)) return bitmapOf(await decodeDepth(format, data));
    const gray = await decodeGray16(data);
    if (gray !== undefined) return bitmapOf(gray);
    try {
      return await createImageBitmap(new Blob([data]));
    } catch {
      throw new Error(`This image (${format.slice(0, 40) || "no format"}) cannot be decoded.`);
    }
  }
}

function bitmapOf(raw: RawImage): Promise<ImageBitmap> {
  return createImageBitmap(new ImageData(toRgba(raw), raw.width, raw.height));
}
