import { farther, moved, turned } from './orbit';
import type { Placement } from './wire';

const kTurnPerHeight = Math.PI; // radians, of a drag as long as the picture is high
const kStep = 0.05; // of a key, in such heights
const kFarther = 1.1; // of a key or a notch of the wheel
const kNotch = 100; // what browsers say of one, in pixels

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

/**
 * Reads off pointer, wheel and keys on `surface` where somebody wants to look from. `from` answers where the gesture
 * starts, null where nothing can be steered; `look` is told each place on the way.
 */
export function follow_gestures(surface: HTMLElement, from: () => Placement | null, look: (to: Placement) => void): void {
  let drag: { pointer: number; start: Placement; x: number; y: number } | null = null;

  surface.addEventListener('pointerdown', (event) => {
    const start = event.button === 0 ? from() : null;
    if (!start || drag) return;
    drag = { pointer: event.pointerId, start, x: event.clientX, y: event.clientY };
    surface.setPointerCapture(event.pointerId);
  });
  surface.addEventListener('pointermove', (event) => {
    if (drag?.pointer !== event.pointerId) return;
    const height = surface.clientHeight || 1;
    look(dragged(drag.start, (event.clientX - drag.x) / height, (event.clientY - drag.y) / height, event.shiftKey));
  });
  for (const end of ['pointerup', 'pointercancel'] as const) {
    surface.addEventListener(end, (event) => { if (drag?.pointer === event.pointerId) drag = null; });
  }

  // Until the picture was chosen, the wheel scrolls the page.
  surface.addEventListener('wheel', (event) => {
    const start = document.activeElement === surface && !event.ctrlKey ? from() : null;
    if (!start) return;
    event.preventDefault();
    look(farther(start, kFarther ** (event.deltaY / kNotch)));
  }, { passive: false });

  surface.addEventListener('keydown', (event) => {
    const step = event.ctrlKey || event.altKey || event.metaKey ? undefined : kKeys[event.key];
    const start = step ? from() : null;
    if (!step || !start) return;
    event.preventDefault();
    look(step(start, event.shiftKey));
  });
}

/** What is seen goes with the pointer, which moved right and down by these heights of the picture. */
function dragged(from: Placement, right: number, down: number, shift: boolean): Placement {
  return shift ? moved(from, -right, down) : turned(from, -right * kTurnPerHeight, down * kTurnPerHeight);
}
