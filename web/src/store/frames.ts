// One requestAnimationFrame loop for the whole page. Only views marked dirty are drawn.

export interface FrameTask {
  /** Draws in the next frame; many marks before it are one. */
  markDirty(): void;
  dispose(): void;
}

const dirty = new Set<() => void>();
let requested = 0;

function run(): void {
  requested = 0;
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

/** Makes a task of the loop; `draw` runs at most once a frame, and not while the page is hidden. */
export function frameTask(draw: () => void): FrameTask {
  let isDisposed = false;
  const task = () => draw();
  return {
    markDirty() {
      if (isDisposed) return;
      dirty.add(task);
      if (requested === 0) requested = requestAnimationFrame(run);
    },
    dispose() {
      isDisposed = true;
      dirty.delete(task);
    },
  };
}
