import { describe, expect, it } from 'vitest';
import { farther, moved, turned } from '../src/orbit';
import type { Placement, Triple } from '../src/wire';

const ahead: Placement = { eye: [0, 1, 4], target: [0, 1, 0], yfov_deg: 90 };
const distance = ({ eye, target }: Placement) => Math.hypot(...eye.map((value, axis) => value - target[axis]!));
const close = (found: Triple, wanted: Triple) => found.forEach((value, axis) => expect(value).toBeCloseTo(wanted[axis]!, 4));

describe('turned', () => {
  it('goes around to the right, level', () => {
    close(turned(ahead, Math.PI / 2, 0).eye, [4, 1, 0]);
    close(turned(ahead, -Math.PI / 2, 0).eye, [-4, 1, 0]);
    close(turned(ahead, Math.PI, 0).eye, [0, 1, -4]);
  });

  it('goes up, and comes back the way it went', () => {
    const above = turned(ahead, 0, Math.PI / 6);
    close(above.eye, [0, 3, 4 * Math.cos(Math.PI / 6)]);
    close(turned(above, 0, -Math.PI / 6).eye, ahead.eye);
  });

  it('keeps its distance and what it looks at', () => {
    for (let right = -7; right < 7; right += 0.9) {
      const there = turned({ ...ahead, target: [1, -2, 0.5] }, right, right / 3);
      expect(distance(there)).toBeCloseTo(distance({ ...ahead, target: [1, -2, 0.5] }), 4);
      expect(there.target).toEqual([1, -2, 0.5]);
    }
  });

  it('stops short of straight down, and leaves it', () => {
    const down = turned(ahead, 0, 9);
    expect(down.eye[1]).toBeGreaterThan(4.99);
    expect(down.eye[2]).toBeGreaterThan(0);
    const straight: Placement = { eye: [0, 5, 0], target: [0, 1, 0], yfov_deg: 40 };
    for (const value of turned(straight, 0.3, -0.5).eye) expect(Number.isFinite(value)).toBe(true);
    expect(distance(turned(straight, 0.3, -0.5))).toBeCloseTo(4, 4);
  });

  it('goes around what is up there', () => {
    close(turned({ eye: [4, 0, 0], target: [0, 0, 0], up: [0, 0, 2], yfov_deg: 40 }, Math.PI / 2, 0).eye, [0, 4, 0]);
  });

  it('goes by small steps, however far from the origin', () => {
    const far: Placement = { eye: [1e5, 0, 1e5 + 1], target: [1e5, 0, 1e5], yfov_deg: 40 };
    close(turned(far, 0.05, 0).eye, [1e5 + Math.sin(0.05), 0, 1e5 + Math.cos(0.05)]);
  });

  it('does not move where there is no distance', () => {
    expect(turned({ ...ahead, eye: [0, 1, 0] }, 1, 1).eye).toEqual([0, 1, 0]);
  });
});

describe('moved', () => {
  it('takes along what is looked at, by heights of the picture', () => {
    const right = moved(ahead, 0.25, 0);   // at a distance of 4 and 90° the picture is 8 high
    close(right.eye, [2, 1, 4]);
    close(right.target, [2, 1, 0]);
    close(moved(ahead, 0, 0.5).target, [0, 5, 0]);
  });

  it('is at right angles to the view', () => {
    const tilted = turned(ahead, 0.4, 0.7);
    const up = moved(tilted, 0, 0.1);
    const view = tilted.target.map((value, axis) => value - tilted.eye[axis]!);
    const way = up.eye.map((value, axis) => value - tilted.eye[axis]!);
    expect(view.reduce((sum, value, axis) => sum + value * way[axis]!, 0)).toBeCloseTo(0, 4);
    expect(way[1]).toBeGreaterThan(0);
  });
});

describe('farther', () => {
  it('is along the view', () => {
    close(farther(ahead, 0.5).eye, [0, 1, 2]);
    close(farther(ahead, 2).eye, [0, 1, 8]);
  });

  it('ends before the eye is what it looks at', () => {
    let near: Placement = { eye: [3, 0, 4], target: [3, 0, 0], yfov_deg: 40 };
    for (let i = 0; i < 500; ++i) near = farther(near, 0.9);
    expect(distance(near)).toBeCloseTo(3e-6, 9);
    expect(distance(farther(near, 2))).toBeCloseTo(6e-6, 9);
    const far: Placement = { eye: [1e5, 0, 1e5 + 4], target: [1e5, 0, 1e5], yfov_deg: 40 };
    close(farther(far, 0.5).eye, [1e5, 0, 1e5 + 2]);
  });
});
