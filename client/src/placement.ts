import { dot, length, minus } from './triple';
import type { Camera, Placement, SceneReport, Triple } from './wire';

const kDigits = 6;
const kLeastHorizon = 0.02; // of what is up in the picture: with less the view is as good as vertical

/** The place of `camera`, looking at what is ahead of it at the distance of the scene's centre. */
export function placement_of(camera: Camera, scene: Pick<SceneReport, 'centre' | 'size'> | null): Placement {
  const { eye, direction, yfov_deg } = camera;
  const diagonal = scene?.size ? length(scene.size) : 0;
  const towards = scene?.centre ? dot(direction, minus(scene.centre, eye)) : 0;
  const distance = towards > 1e-4 * diagonal ? towards : diagonal / 10 || 1; // where the centre is behind it, or in it
  const target = eye.map((at, axis) => at + distance * direction[axis]!) as Triple;
  const up = is_level(camera) ? {} : { up: rounded(camera.up, kDigits) };
  return readable({ eye, target, ...up, yfov_deg: Number((yfov_deg ?? 40).toPrecision(4)) });
}

/** Without digits that nobody sees: what counts is how far it is from what is looked at, not from the origin. */
export function readable(place: Placement): Placement {
  const { eye, target, yfov_deg } = place;
  const distance = length(minus(eye, target));
  const decimals = Math.max(0, Math.min(100, kDigits - 1 - Math.floor(Math.log10(distance))));
  const angle = Number(yfov_deg.toPrecision(kDigits));
  return { ...place, eye: rounded(eye, decimals), target: rounded(target, decimals), yfov_deg: angle };
}

function rounded(a: Triple, decimals: number): Triple {
  return a.map((value) => Number(value.toFixed(decimals)) + 0) as Triple;
}

/** Whether +Y is up in the picture. */
function is_level({ direction, up }: Camera): boolean {
  const tilt = direction[2] * up[0] - direction[0] * up[2]; // the height of what is to the right
  return up[1] > kLeastHorizon && Math.abs(tilt) < 1e-3;
}
