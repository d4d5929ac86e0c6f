import { farther, moved, turned } from './orbit';
import type { Placement } from './wire';

const kTurnPerHeight = Math.PI; // radians, of a drag as long as the picture is high
const kStep = 0.05; // of a key, in such heights
const kFarther = 1.1; // of a key or a notch of the wheel
const kNotch = 100; // what browsers say of one, in pixels
const kStill = 4; // pixels: less is a click, which only chooses the picture

/** Keys that steer, and where they lead from a place; with Shift, arrows move instead of turning. */
const kKeys: Record<string, (from: Placement, shift: boolean) => Placement> = {
  ArrowLeft: (from, shift) => dragged(from, kStep, 0, shift),
  ArrowRight: (from, shift) => dragged(from, -kStep, 0, shift),
  ArrowUp: (from, shift) => dragged(from, 0, kStep, shift),
  ArrowDown: (from, shift) => dragged(from, 0, -kStep, shift),
  '+': (from) => farther(from, 1 / kFarther),
  '=': (from) => farther(from, 1 / kFarther),
  '-': (from) => farther(from, kFarther),
};

/** A pointer that is down, and where it leads. */
interface Drag {
  readonly pointer: number;
  /** Where it began, or where Shift was pressed or let go. */
  start: Placement;
  x: number;
  y: number;
  shift: boolean;
  /** Null until it is known for a drag. */
  to: Placement | null;
}

/**
 * Reads off pointer, wheel and keys on `surface` where somebody wants to look from. `from` answers where the gesture
 * starts, null where nothing can be steered; `look` is told each place on the way. Answers what ends a drag.
 */
export function follow_gestures(
  surface: HTMLElement, from: () => Placement | null, look: (to: Placement) => void,
): () => void {
  let drag: Drag | null = null;

  surface.addEventListener('pointerdown', (event) => {
    const start = event.button === 0 && !drag ? from() : null;
    if (!start) return;
    drag = { pointer: event.pointerId, start, x: event.clientX, y: event.clientY, shift: event.shiftKey, to: null };
    surface.setPointerCapture(event.pointerId);
  });
  surface.addEventListener('pointermove', (event) => {
    if (drag?.pointer !== event.pointerId) return;
    if (drag.shift !== event.shiftKey) {
      drag.start = drag.to ?? drag.start;
      [drag.x, drag.y, drag.shift] = [event.clientX, event.clientY, event.shiftKey];
    }
    const [right, down] = [event.clientX - drag.x, event.clientY - drag.y];
    if (!drag.to && !is_drag(event, right, down)) return;
    const height = surface.clientHeight || 1;
    const to = dragged(drag.start, right / height, down / height, event.shiftKey);
    if (differ(to, drag.to)) look(to);
    drag.to = to;
  });
  surface.addEventListener('lostpointercapture', (event) => { if (drag?.pointer === event.pointerId) drag = null; });

  // Until the picture was chosen, the wheel scrolls the page.
  surface.addEventListener('wheel', (event) => {
    const start = document.activeElement === surface && !event.ctrlKey && event.deltaY !== 0 ? from() : null;
    if (!start) return;
    event.preventDefault();
    look(farther(start, kFarther ** (event.deltaY / kNotch)));
  }, { passive: false });

  surface.addEventListener('keydown', (event) => {
    const step = event.ctrlKey || event.altKey || event.metaKey ? undefined : kKeys[event.key];
    const start = step ? from() : null;
    if (!step || !start) return;
    event.preventDefault();
    const to = step(start, event.shiftKey);
    if (differ(to, start)) look(to);
  });

  return () => { drag = null; };
}

/** Whether it is more than a click, and than what scrolls the page where a finger does that. */
function is_drag({ pointerType }: PointerEvent, right: number, down: number): boolean {
  const scrolls = pointerType === 'touch' && Math.abs(down) > Math.abs(right);
  return Math.hypot(right, down) >= kStill && !scrolls;
}

function differ(a: Placement, b: Placement | null): boolean {
  return JSON.stringify(a) !== JSON.stringify(b);
}

/** What is seen goes with the pointer, which moved right and down by these heights of the picture. */
function dragged(from: Placement, right: number, down: number, shift: boolean): Placement {
  return shift ? moved(from, -right, down) : turned(from, -right * kTurnPerHeight, down * kTurnPerHeight);
}
