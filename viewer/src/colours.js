/** Colours: those of light and dark pages, and of what is marked. */

export const THEMES = {
  light: { sky: 0xf3f5f8, ground: 0xe6eaef, grid: 0xb9c2cd, label: "#1f2933" },
  dark: { sky: 0x171b21, ground: 0x1f252d, grid: 0x3a4450, label: "#e6eaf0" },
};

export const COLLISION = 0xe8833a;
export const TOUCHING = 0xd7263d;
export const SELECTED = 0x2f80ed;
export const GHOST = 0xd6409f; // what was before
