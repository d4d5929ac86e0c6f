import { describe, expect, it } from 'vitest';
import { placement_of } from '../src/placement';
import type { Camera } from '../src/wire';

const camera: Camera = { name: '', eye: [0, 1, 3.9000000953674316], direction: [0, 0, -1], yfov_deg: 39.30490493774414 };

describe('placement_of', () => {
  it('is where the camera is, and looks ahead as far as the scene\'s centre is', () => {
    expect(placement_of(camera, [5, 1, 0])).toEqual({ eye: [0, 1, 3.9], target: [0, 1, 0], yfov_deg: 39.3 });
  });

  it('looks a metre ahead where the scene is behind it or nowhere', () => {
    expect(placement_of(camera, [0, 1, 9]).target).toEqual([0, 1, 2.9]);
    expect(placement_of(camera, null).target).toEqual([0, 1, 2.9]);
  });

  it('gives an angle to a camera that has none', () => {
    expect(placement_of({ ...camera, yfov_deg: null }, null).yfov_deg).toBe(40);
  });
});
