// A small chart of the last values, without axes.

const WIDTH = 120;
const HEIGHT = 28;
// The smallest number of values that fill the width.
const MIN_SHOWN = 20;

export function Sparkline({ values, length }: { values: readonly number[]; length: number }) {
  const finite = values.filter(Number.isFinite);
  const low = Math.min(...finite);
  const high = Math.max(...finite);
  // A steady value is a line in the middle, not magnified noise.
  const span = Math.max(high - low, Math.abs(high) * 0.05, 1e-9);
  const middle = (low + high) / 2;
  // A line that has just begun is drawn larger.
  const shownCount = Math.min(length, Math.max(MIN_SHOWN, values.length));
  let path = "";
  let area = "";
  let isDown = false;
  let lastX = 0;
  const closeArea = () => {
    if (isDown) area += `L${lastX.toFixed(1)} ${HEIGHT}Z`;
    isDown = false;
  };
  values.forEach((value, index) => {
    if (!Number.isFinite(value)) {
      closeArea();
      return;
    }
    const x = WIDTH - ((values.length - 1 - index) / (shownCount - 1)) * WIDTH;
    const y = HEIGHT / 2 - ((value - middle) / span) * (HEIGHT - 4);
    const point = `${x.toFixed(1)} ${y.toFixed(1)}`;
    path += `${isDown ? "L" : "M"}${point}`;
    area += isDown ? `L${point}` : `M${x.toFixed(1)} ${HEIGHT}L${point}`;
    isDown = true;
    lastX = x;
  });
  closeArea();
  return (
    <svg class="sparkline" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden="true">
      <path class="sparkline-area" d={area} />
      <path d={path} />
    </svg>
  );
}
