// Names in the 3D picture: they have the same size on the screen at any distance, and never overlap.
import { type PerspectiveCamera, Sprite, SpriteMaterial, Vector2, Vector3 } from "three";
import { textTexture } from "./shapes.ts";

const HEIGHT_PX = 17;
/** The text is drawn finer than most screens are. */
const PIXEL_RATIO = 2;

/** A name that floats above its position. */
export class Caption extends Sprite {
  readonly widthPx: number;

  constructor(text: string, color: string, halo: string) {
    const map = textTexture(text, HEIGHT_PX * PIXEL_RATIO, color, halo);
    super(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
    this.widthPx = (map.image as HTMLCanvasElement).width / PIXEL_RATIO;
    this.center.set(0.5, -0.3);
    this.renderOrder = 10;
  }
}

/**
 * Gives captions their size in a picture of this many pixels, and hides those that would cover an earlier one.
 *
 * Captions behind the camera have a position in the picture too, but cover nothing.
 */
export function arrangeCaptions(captions: Iterable<Caption>, camera: PerspectiveCamera, size: Vector2): void {
  const unitsPerPx = (2 * Math.tan((camera.fov * Math.PI) / 360)) / size.y;
  const shown: { at: Vector2; widthPx: number }[] = [];
  camera.updateMatrixWorld();
  for (const caption of captions) {
    caption.scale.set(caption.widthPx * unitsPerPx, HEIGHT_PX * unitsPerPx, 1);
    const projected = caption.getWorldPosition(new Vector3()).project(camera);
    const at = new Vector2(projected.x, projected.y).multiply(size).multiplyScalar(0.5);
    caption.visible = !shown.some(
      (other) =>
        Math.abs(other.at.x - at.x) < (other.widthPx + caption.widthPx) / 2 &&
        Math.abs(other.at.y - at.y) < HEIGHT_PX,
    );
    if (caption.visible && projected.z <= 1) shown.push({ at, widthPx: caption.widthPx });
  }
}
