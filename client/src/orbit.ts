import { readable } from './placement';
import { cross, dot, length, minus, plus, scaled, unit } from './triple';
import type { Placement, Triple } from './wire';

const kUp: Triple = [0, 1, 0];
const kSteepest = (89 / 180) * Math.PI; // short of straight up and down, where a camera has no horizon
const kNearest = 1e-6; // of what is looked at, against the size of its coordinates: the server's have seven digits

/** The camera turned about what it looks at: by angles to the right and upwards, in radians, never over the top. */
export function turned(from: Placement, right: number, upwards: number): Placement {
  const axis = axis_of(from);
  const offset = minus(from.eye, from.target);
  const distance = length(offset);
  if (distance === 0) return from;
  const height = dot(offset, axis) / distance;
  const flat = minus(offset, scaled(axis, height * distance));
  const out = unit(length(flat) > 1e-6 * distance ? flat : any_across(axis));
  const about = plus(scaled(out, Math.cos(right)), scaled(cross(axis, out), Math.sin(right)));
  const elevation = Math.max(-kSteepest, Math.min(kSteepest, Math.asin(Math.max(-1, Math.min(1, height))) + upwards));
  const to_eye = plus(scaled(about, Math.cos(elevation)), scaled(axis, Math.sin(elevation)));
  return readable({ ...from, eye: plus(from.target, scaled(to_eye, distance)) });
}

/** The camera and what it looks at moved sideways, in heights of the picture at that distance. */
export function moved(from: Placement, right: number, up: number): Placement {
  const ahead = minus(from.target, from.eye);
  const distance = length(ahead);
  if (distance === 0) return from;
  const sideways = unit_across(ahead, axis_of(from));
  const upright = unit(cross(sideways, ahead));
  const height = 2 * distance * Math.tan((from.yfov_deg / 360) * Math.PI);
  const step = plus(scaled(sideways, right * height), scaled(upright, up * height));
  return readable({ ...from, eye: plus(from.eye, step), target: plus(from.target, step) });
}

/** The camera at `factor` times its distance from what it looks at. */
export function farther(from: Placement, factor: number): Placement {
  const offset = minus(from.eye, from.target);
  const distance = length(offset);
  if (distance === 0) return from;
  const least = kNearest * Math.max(...from.target.map(Math.abs)) / distance;
  return readable({ ...from, eye: plus(from.target, scaled(offset, Math.max(factor, Math.min(1, least)))) });
}

function axis_of({ up = kUp }: Placement): Triple {
  return length(up) > 0 ? unit(up) : kUp;
}

/** To the right of who looks `ahead`, level. */
function unit_across(ahead: Triple, axis: Triple): Triple {
  const across = cross(ahead, axis);
  return unit(length(across) > 1e-6 * length(ahead) ? across : any_across(axis));
}

function any_across(axis: Triple): Triple {
  return cross(axis, Math.abs(axis[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]);
}
