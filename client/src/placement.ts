import type { Camera, Placement, Triple } from './wire';

/** The place of `camera`, looking at what is ahead of it at the distance of `centre`, the scene's. */
export function placement_of({ eye, direction, yfov_deg }: Camera, centre: Triple | null): Placement {
  const towards = centre ? dot(direction, eye.map((at, axis) => centre[axis]! - at)) : 0;
  const distance = towards > 0 ? towards : 1;
  const target = eye.map((at, axis) => at + distance * direction[axis]!);
  return { eye: rounded(eye), target: rounded(target), yfov_deg: Number((yfov_deg ?? 40).toPrecision(4)) };
}

function dot(a: number[], b: number[]): number {
  return a.reduce((sum, value, axis) => sum + value * b[axis]!, 0);
}

function rounded(triple: number[]): Triple {
  const [x = 0, y = 0, z = 0] = triple.map((value) => Number(value.toPrecision(5)));
  return [x, y, z];
}
