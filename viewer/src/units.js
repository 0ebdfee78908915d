/** Numbers as people read them: millimetres and degrees, or metres and radians. */

export const UNITS = {
  "mm, deg": { length: ["mm", 1000, 2], angle: ["deg", 180 / Math.PI, 2] },
  "m, rad": { length: ["m", 1, 5], angle: ["rad", 1, 5] },
};

/** Return the digits that the page shows of a value (m or rad) in a unit of the table above. */
export function digits(value, [, factor, places]) {
  const number = (value * factor).toFixed(places).replace(/\.?0+$/, "");
  return number === "-0" ? "0" : number;
}

/** Return a value (m or rad) in a unit of the table above. */
export function plain(value, unit) {
  return `${digits(value, unit)} ${unit[0]}`;
}

/** Return a length (m) with its unit. */
export function length(value, units) {
  return plain(value, UNITS[units].length);
}

/** Return an angle (rad) with its unit. */
export function angle(value, units) {
  return plain(value, UNITS[units].angle);
}

/** Return several numbers of one kind, the unit once. */
export function vector(values, units, kind = "length") {
  const unit = UNITS[units][kind];
  return `${values.map((value) => digits(value, unit)).join("  ")} ${unit[0]}`;
}

/** Return the kind of unit that a coordinate of a joint has. */
export function kindOf(jointType, coordinate = "position") {
  if (jointType === "prismatic" || ["x", "y", "z"].includes(coordinate)) return "length";
  return "angle";
}

const NUMBER = "[-+]?\\d[\\d.]*(?:e[-+]?\\d+)?";
const UNIT = "(rad|m)(/s)?(?![\\w*/^])";
const STEP = new RegExp(`(?<= )(${NUMBER}) -> (${NUMBER}) ${UNIT}`, "g");
const GIVEN = new RegExp(`(?<=, was |: new, |, new, |: removed, )(${NUMBER}) ${UNIT}`, "g");
const FEWEST = 5; // digits of a number that was printed with six

/** Return numbers with as few digits as show their difference. */
function apart(values) {
  const difference = Math.abs(values[1] - values[0]);
  for (let precision = FEWEST; precision < 17; precision += 1) {
    const [before, after] = values.map((value) => Number(value.toPrecision(precision)));
    if (Math.abs(Math.abs(after - before) - difference) <= 0.05 * difference) return [before, after];
  }
  return values;
}

/** Return a sentence on what changed, in metres and radians as everywhere, in the units that the page shows. */
export function inUnits(text, units) {
  const kinds = { m: UNITS[units].length, rad: UNITS[units].angle };
  const stepped = text.replace(STEP, (_, old, now, name, per = "") => {
    const [unit, factor] = kinds[name];
    const numbers = factor === 1 ? [old, now] : apart([Number(old) * factor, Number(now) * factor]);
    return `${numbers.join(" -> ")} ${unit}${per}`;
  });
  return stepped.replace(GIVEN, (_, value, name, per = "") => {
    const [unit, factor] = kinds[name];
    return `${factor === 1 ? value : Number((Number(value) * factor).toPrecision(FEWEST))} ${unit}${per}`;
  });
}
