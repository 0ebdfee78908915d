/** Numbers as people read them: millimetres and degrees, or metres and radians. */

export const UNITS = {
  "mm, deg": { length: ["mm", 1000, 2], angle: ["deg", 180 / Math.PI, 2] },
  "m, rad": { length: ["m", 1, 5], angle: ["rad", 1, 5] },
};

function shown([unit, factor, digits], value) {
  const number = (value * factor).toFixed(digits).replace(/\.?0+$/, "");
  return `${number === "-0" ? "0" : number} ${unit}`;
}

/** Return a length (m) with its unit. */
export function length(value, units) {
  return shown(UNITS[units].length, value);
}

/** Return an angle (rad) with its unit. */
export function angle(value, units) {
  return shown(UNITS[units].angle, value);
}

/** Return several numbers of one kind, the unit once. */
export function vector(values, units, kind = "length") {
  const [unit] = UNITS[units][kind];
  const numbers = values.map((value) => shown(UNITS[units][kind], value).replace(` ${unit}`, ""));
  return `${numbers.join("  ")} ${unit}`;
}

/** Return the kind of unit that a coordinate of a joint has. */
export function kindOf(jointType, coordinate = "position") {
  if (jointType === "prismatic" || ["x", "y", "z"].includes(coordinate)) return "length";
  return "angle";
}
