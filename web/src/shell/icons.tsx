// Icons as paths on a grid of 24 x 24, drawn with lines.

const PATHS = {
  overview: "M4 4h7v9H4zM13 4h7v5h-7zM13 11h7v9h-7zM4 15h7v5H4z",
  boards: "M6 6h12v12H6zM9 2v4M15 2v4M9 18v4M15 18v4M2 9h4M2 15h4M18 9h4M18 15h4M10 10h4v4h-4z",
  topics: "M4 6h3M4 12h3M4 18h3M10 6h10M10 12h10M10 18h10",
  plots: "M4 4v16h16M7 15l4-5 3 3 5-7",
  images: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15 9h.01",
  scene: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  map: "M9 4L3 6.5v13L9 17l6 2.5 6-2.5V4l-6 2.5zM9 4v13M15 6.5v13",
  graph:
    "M6 9a3 3 0 100-6 3 3 0 000 6zM18 21a3 3 0 100-6 3 3 0 000 6zM18 9a3 3 0 100-6 3 3 0 000 6zM9 6h6M7.5 8.5l8.5 7.5",
  controls: "M4 8h9M17 8h3M4 16h3M11 16h9M15 5.5v5M9 13.5v5",
  drive:
    "M12 3v18M3 12h18M12 3l-2.5 2.5M12 3l2.5 2.5M12 21l-2.5-2.5M12 21l2.5-2.5M3 12l2.5-2.5M3 12l2.5 2.5M21 12l-2.5-2.5M21 12l-2.5 2.5",
  console: "M4 5h16v14H4zM7 9l3 3-3 3M12 15h5",
  parameters: "M6 3v6M6 13v8M12 3v10M12 17v4M18 3v4M18 11v10M4 11h4M10 15h4M16 9h4",
  services: "M4 8h14l-3-3M20 16H6l3 3",
  diagnostics: "M3 12h4l3-8 4 16 3-8h4",
  frames: "M12 14V4M12 14l8 5M12 14l-8 5M12 4l-2 2.5M12 4l2 2.5",
  recording: "M12 20a8 8 0 100-16 8 8 0 000 16zM12 15a3 3 0 100-6 3 3 0 000 6z",
  simulation: "M9 3h6M10 3v6l-5 9a2 2 0 002 3h10a2 2 0 002-3l-5-9V3M7.5 15h9",
  sensors:
    "M12 14a2 2 0 100-4 2 2 0 000 4zM8 16a6 6 0 010-8M16 8a6 6 0 010 8M5 19a10 10 0 010-14M19 5a10 10 0 010 14",
  fleet: "M3 8h8v6H3zM13 8h8v6h-8zM5 17h.01M9 17h.01M15 17h.01M19 17h.01M7 8V5M17 8V5",
  more: "M4 7h16M4 12h16M4 17h16",
  plug: "M9 3v5M15 3v5M6 8h12v3a6 6 0 01-12 0zM12 17v4",
  phone: "M8 2h8a2 2 0 012 2v16a2 2 0 01-2 2H8a2 2 0 01-2-2V4a2 2 0 012-2zM11 18.5h2",
  search: "M11 18a7 7 0 100-14 7 7 0 000 14zM16 16l5 5",
  copy: "M9 9h11v11H9zM5 15H4V4h11v1",
  pause: "M8 5v14M16 5v14",
  play: "M7 4.5v15l12-7.5z",
  close: "M6 6l12 12M18 6L6 18",
  sun: "M12 16a4 4 0 100-8 4 4 0 000 8zM12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.4 1.4M17.6 17.6L19 19M5 19l1.4-1.4M17.6 6.4L19 5",
  moon: "M20 14.5A8.5 8.5 0 119.5 4 7 7 0 0020 14.5z",
  stop: "M8 3h8l5 5v8l-5 5H8l-5-5V8z",
  download: "M12 4v11M7.5 11l4.5 4.5 4.5-4.5M4 20h16",
  pin: "M9 3h6l-1 7 4 4H6l4-4zM12 14v7",
  plus: "M12 5v14M5 12h14",
  check: "M5 12.5l4.5 4.5L19 7",
  warning: "M12 4l9 16H3zM12 10v5M12 17.5h.01",
  flip: "M12 3v18M9 7l-6 10h6zM15 7l6 10h-6z",
  rotate: "M20 12a8 8 0 11-2.3-5.7L20 8.5M20 4v4.5h-4.5",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  chevron: "M9 6l6 6-6 6",
  back: "M15 6l-6 6 6 6",
  axis: "M5 4v16M5 4L3 6.5M5 4l2 2.5M11 8h9M11 13h6M11 18h8",
  trash: "M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name, size = 20 }: { name: IconName; size?: number }) {
  return (
    <svg class="icon" width={size} height={size} viewBox="0 0 24 24" aria-hidden="true">
      <path d={PATHS[name]} />
    </svg>
  );
}
