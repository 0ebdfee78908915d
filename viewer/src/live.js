/** Following the files: the server tells when the robot is another one, or does not compile. */

/** Say whether the page came from a server that follows the files; one that was opened from disk has nobody to ask. */
function isLive() {
  return Boolean(document.body.dataset.live) && window.location.protocol.startsWith("http");
}

/**
 * Listen, and call back with what is new. The server names its version at each connection, so that nothing is missed
 * between the page and its events, nor while a machine slept. What it tells is taken in its order.
 */
export function follow({ onrobot, onproblem, onstate }) {
  if (!isLive()) return;
  let version = document.body.dataset.live;
  let before = Promise.resolve();
  const inOrder = (event, step) => {
    before = before.then(() => step(JSON.parse(event.data))).catch(() => onstate("the compiler does not answer"));
  };
  const events = new EventSource("events");
  events.addEventListener("robot", (event) =>
    inOrder(event, async (told) => {
      if (told === version) return;
      const next = await (await fetch("robot.json", { cache: "no-store" })).json();
      version = next.version;
      if (next.robot) onrobot(next);
    }),
  );
  events.addEventListener("problem", (event) => inOrder(event, onproblem));
  events.onopen = () => onstate("follows the files");
  events.onerror = () => onstate("the compiler has stopped");
}

/** Ask where the numbers of a frame come from, line by line; empty where nobody answers that. */
export async function explained(frame) {
  if (!isLive()) return [];
  try {
    const answer = await fetch(`explain?frame=${encodeURIComponent(frame)}`);
    return answer.ok ? await answer.json() : [];
  } catch {
    return [];
  }
}

/** Ask which links touch at a state: their pairs, or why nobody knows. */
export async function touching(state) {
  if (!isLive()) return "parts that touch are marked in the page that rosorin-compile view serves";
  try {
    const answer = await fetch("touching", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(state) });
    return answer.ok ? await answer.json() : `${UNKNOWN}: ${(await answer.text()).trim()}`;
  } catch {
    return `${UNKNOWN}: the compiler has stopped`;
  }
}

const UNKNOWN = "which parts touch is not known";
