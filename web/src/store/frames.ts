// One requestAnimationFrame loop for the whole page. Only views marked dirty are drawn.

export interface FrameTask {
  /** Draws once in the next frame, however often it is called before. */
  markDirty(): void;
  dispose(): void;
}

const dirty = new Set<() => void>();
let isRequested = false;
let periodMs = 0;
let ranMs = 0;

/** Sets the shortest time between two frames; 0 is the screen's rate. Without a graphics card, each frame is expensive. */
export function limitFrames(shortestMs: number): void {
  periodMs = shortestMs;
}

function request(): void {
  isRequested = true;
  const waitMs = periodMs - (performance.now() - ranMs);
  if (waitMs <= 0) requestAnimationFrame(run);
  else setTimeout(() => requestAnimationFrame(run), waitMs);
}

function run(): void {
  isRequested = false;
  ranMs = performance.now();
  const tasks = [...dirty];
  dirty.clear();
  for (const each of tasks) {
    try {
      each();
    } catch (error) {
      // One broken panel must not stop the others.
      console.error(error);
    }
  }
}

/** Creates a task of the loop; `draw` runs at most once a frame, and not while the page is hidden. */
export function frameTask(draw: () => void): FrameTask {
  let isDisposed = false;
  const task = () => draw();
  return {
    markDirty() {
      if (isDisposed) return;
      dirty.add(task);
      if (!isRequested) request();
    },
    dispose() {
      isDisposed = true;
      dirty.delete(task);
    },
  };
}
