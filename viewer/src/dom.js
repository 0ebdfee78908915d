/** Elements of the page, without a framework. */

/**
 * Return a new element: `element("button", {class: "quiet", onclick: f}, "text", child)`. Attributes that are false or
 * undefined are left out; those that begin with "on" are listeners.
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== undefined && child !== null && child !== false));
  return made;
}

/** Return a labelled checkbox that tells what it is switched to. */
export function toggle(label, checked, onchange, { id, title, swatch, disabled } = {}) {
  const box = element("input", { type: "checkbox", checked, id, disabled, onchange: () => onchange(box.checked) });
  return element("label", { class: "toggle", title }, box, swatch && dot(swatch), element("span", {}, label));
}

/** Return a round spot of a colour. */
export function dot(colour) {
  return element("i", { class: "dot", style: `background:${colour}` });
}

const folded = new Set(["Help"]); // titles

/** Return a section of a panel: a heading that folds what is below; it stays folded when the panel is drawn anew. */
export function section(title, ...children) {
  const made = element("details", { class: "section", open: !folded.has(title) }, element("summary", {}, title), ...children);
  made.addEventListener("toggle", () => folded[made.open ? "delete" : "add"](title));
  return made;
}

/** Copy a text, and say so on the button that was pressed. */
export async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const field = element("textarea", {}, text); // a page of another machine has no clipboard
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
  }
  button.dataset.label ??= button.textContent;
  button.textContent = "copied";
  setTimeout(() => (button.textContent = button.dataset.label), 900);
}
