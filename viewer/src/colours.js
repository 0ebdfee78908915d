/** Colours: a look for each link that has none, and those of light and dark pages. */

const GOLDEN_ANGLE = 137.50776;

/** Return a colour for the link of that number: calm, and told apart from its neighbours. */
export function ofLink(index) {
  const hue = (212 + index * GOLDEN_ANGLE) % 360;
  return `hsl(${hue.toFixed(1)}, ${index === 0 ? 10 : 42}%, ${index % 2 ? 52 : 60}%)`;
}

export const THEMES = {
  light: { sky: 0xf3f5f8, ground: 0xe6eaef, grid: 0xb9c2cd, label: "#1f2933" },
  dark: { sky: 0x171b21, ground: 0x1f252d, grid: 0x3a4450, label: "#e6eaf0" },
};

export const COLLISION = 0xe8833a;
export const TOUCHING = 0xd7263d;
export const SELECTED = 0x2f80ed;
export const GHOST = 0xd6409f; // what was before
