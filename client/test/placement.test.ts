import { describe, expect, it } from 'vitest';
import { placement_of, readable } from '../src/placement';
import type { Camera, Placement, Triple } from '../src/wire';

const camera: Camera = {
  name: '', eye: [0, 1, 3.9000000953674316], direction: [0, 0, -1], up: [0, 1, 0], yfov_deg: 39.30490493774414,
};
const scene = (centre: Triple, size: Triple = [3, 4, 0]) => ({ centre, size });

describe('placement_of', () => {
  it('is where the camera is, and looks ahead as far as the scene\'s centre is', () => {
    expect(placement_of(camera, scene([5, 1, 0]))).toEqual({ eye: [0, 1, 3.9], target: [0, 1, 0], yfov_deg: 39.3 });
  });

  it('looks a tenth of the scene ahead where its centre is behind or beside the camera', () => {
    expect(placement_of(camera, scene([0, 1, 9])).target).toEqual([0, 1, 3.4]);
    expect(placement_of(camera, scene([0, 1, 3.9])).target).toEqual([0, 1, 3.4]);
    expect(placement_of({ ...camera, eye: [0, 0, 0] }, scene([0, 0, 1], [3e-4, 4e-4, 0])).target).toEqual([0, 0, -5e-5]);
    expect(placement_of(camera, null).target).toEqual([0, 1, 2.9]);
    expect(placement_of(camera, { centre: null, size: null }).target).toEqual([0, 1, 2.9]);
  });

  it('keeps what is up in the picture where that is not the vertical', () => {
    const down: Camera = { ...camera, direction: [0, -1, 2e-16], up: [0, -2e-16, -1] };
    expect(placement_of(down, null).up).toEqual([0, 0, -1]);
    const rolled: Camera = { ...camera, up: [0.6, 0.8, 0] };
    expect(placement_of(rolled, null).up).toEqual([0.6, 0.8, 0]);
    expect(placement_of({ ...camera, up: [0, -1, 0] }, null).up).toEqual([0, -1, 0]);
    const tilted: Camera = { ...camera, direction: [0.48, -0.6, -0.64], up: [0.36, 0.8, -0.48] };
    expect(placement_of(tilted, null)).not.toHaveProperty('up');
  });

  it('gives an angle to a camera that has none', () => {
    expect(placement_of({ ...camera, yfov_deg: null }, null).yfov_deg).toBe(40);
  });
});

describe('readable', () => {
  const at = (eye: Triple, target: Triple): Placement => ({ eye, target, yfov_deg: 39.29999923706055 });

  it('leaves the digits out that single precision adds', () => {
    expect(readable(at([0.10000000149011612, 1, 4.300000190734863], [-0, 1e-9, 0])))
      .toEqual({ eye: [0.1, 1, 4.3], target: [0, 0, 0], yfov_deg: 39.3 });
  });

  it('keeps those that are seen, however small and however far away everything is', () => {
    expect(readable(at([100000.328125, 0, 1.5], [100000, 0, 0.5])).eye).toEqual([100000.32813, 0, 1.5]);
    expect(readable(at([1.234567e-5, 0, 0], [0, 0, 0])).eye).toEqual([1.23457e-5, 0, 0]);
    expect(readable(at([1e18, 0, 0], [0, 0, 0])).eye).toEqual([1e18, 0, 0]);
    expect(readable(at([0.3, 0, 0], [0.3, 0, 0])).eye).toEqual([0.3, 0, 0]);
  });
});
