import { beforeEach, describe, expect, it, vi } from 'vitest';
import { follow_gestures } from '../src/gestures';
import type { Placement } from '../src/wire';

const start: Placement = { eye: [0, 0, 4], target: [0, 0, 0], yfov_deg: 90 };

/** A picture 100 pixels high, and what was looked from. */
class Surface extends EventTarget {
  readonly clientHeight = 100;
  from: Placement | null = start;
  readonly places: Placement[] = [];
  readonly end = follow_gestures(this as unknown as HTMLElement, () => this.from, (to) => this.places.push(to));

  setPointerCapture(): void {}

  send(type: string, facts: object): Event {
    const unmodified = { ctrlKey: false, altKey: false, metaKey: false, shiftKey: false };
    const event = Object.assign(new Event(type, { cancelable: true }), { pointerId: 1, button: 0, ...unmodified, ...facts });
    this.dispatchEvent(event);
    return event;
  }

  down(facts: object = {}): void {
    this.send('pointerdown', { clientX: 50, clientY: 50, ...facts });
  }

  move(clientX: number, facts: object = {}): void {
    this.send('pointermove', { clientX, clientY: 50, ...facts });
  }
}

describe('a drag', () => {
  it('turns, and brings the picture back where it goes back', () => {
    const surface = new Surface();
    surface.down();
    for (const x of [75, 50]) surface.move(x);
    expect(surface.places[0]?.eye[0]).toBeLessThan(-2);
    expect(surface.places[1]).toEqual(start);
  });

  it('is more than a click with a hand that is not quite still', () => {
    const surface = new Surface();
    surface.down();
    for (const x of [51, 49, 52, 50]) surface.move(x);
    surface.send('lostpointercapture', {});
    expect(surface.places).toEqual([]);
  });

  it('is not what scrolls the page', () => {
    const surface = new Surface();
    const touch = { pointerType: 'touch' };
    surface.down(touch);
    surface.move(52, { ...touch, clientY: 33 });
    expect(surface.places).toEqual([]);
    surface.move(70, { ...touch, clientY: 33 });
    surface.move(70, { ...touch, clientY: 20 });
    expect(surface.places).toHaveLength(2);
  });

  it('goes on from where it is when Shift is pressed or let go', () => {
    const surface = new Surface();
    surface.down();
    surface.move(75);
    surface.move(75, { shiftKey: true });
    surface.move(80, { shiftKey: true });
    const [turned, moved] = surface.places as [Placement, Placement];
    expect(surface.places).toHaveLength(2);
    const way = moved.eye.map((value, axis) => value - turned.eye[axis]!);
    expect(Math.hypot(...way)).toBeCloseTo(0.05 * 8, 3);
    surface.move(80);
    surface.move(55);
    expect(surface.places[2]?.target).toEqual(moved.target);
    expect(surface.places[2]?.eye[0]).toBeCloseTo(moved.target[0], 3);
  });

  it('ends with its pointer, or when it is told to', () => {
    const surface = new Surface();
    surface.down();
    surface.send('lostpointercapture', { pointerId: 2 });
    surface.move(60);
    surface.send('lostpointercapture', {});
    surface.move(70);
    expect(surface.places).toHaveLength(1);
    surface.down();
    surface.end();
    surface.move(70);
    expect(surface.places).toHaveLength(1);
  });

  it('is not begun by another button, by a second finger, or where nothing can be steered', () => {
    const surface = new Surface();
    surface.down({ button: 2 });
    surface.move(70);
    expect(surface.places).toEqual([]);
    surface.down();
    surface.down({ pointerId: 2, clientX: 0 });
    surface.move(70, { pointerId: 2 });
    expect(surface.places).toEqual([]);
    surface.end();
    surface.from = null;
    surface.down();
    surface.move(70);
    expect(surface.places).toEqual([]);
  });
});

describe('the wheel', () => {
  let surface: Surface;
  beforeEach(() => {
    surface = new Surface();
    vi.stubGlobal('document', { activeElement: surface });
  });

  it('goes nearer and farther, and does not scroll then', () => {
    expect(surface.send('wheel', { deltaY: 100 }).defaultPrevented).toBe(true);
    expect(surface.places[0]?.eye[2]).toBeCloseTo(4.4);
  });

  it('does nothing sideways, with Ctrl, or before the picture was chosen', () => {
    expect(surface.send('wheel', { deltaY: 0, deltaX: 50 }).defaultPrevented).toBe(false);
    surface.send('wheel', { deltaY: 100, ctrlKey: true });
    vi.stubGlobal('document', { activeElement: null });
    surface.send('wheel', { deltaY: 100 });
    expect(surface.places).toEqual([]);
  });
});

describe('keys', () => {
  it('lead nowhere where nothing changes', () => {
    const surface = new Surface();
    surface.send('keydown', { key: 'ArrowUp' });
    expect(surface.places).toHaveLength(1);
    for (let i = 0; i < 50; ++i) {
      surface.from = surface.places.at(-1)!;
      surface.send('keydown', { key: 'ArrowUp' });
    }
    expect(surface.places.length).toBeLessThan(12);
  });
});
