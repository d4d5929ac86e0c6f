import { scene_name, type State } from './state';
import type { Job, JobState, Method } from './wire';

export const kStateNames: Record<JobState, string> = {
  queued: 'Queued', preparing: 'Preparing', rendering: 'Rendering', finalizing: 'Finishing', succeeded: 'Done',
  canceling: 'Canceling', canceled: 'Canceled', failed: 'Failed', paused: 'Paused',
};

export const kMethodNames: Record<Method, string> = {
  auto: 'auto', path: 'path tracing', photon_map: 'photon map', progressive: 'progressive photon mapping',
  hybrid: 'paths and photons',
};

export const kMethodHints: Record<Method, string> = {
  auto: 'Chosen by what the scene needs.',
  progressive: 'Photon maps with shrinking radius: right in the end, caustics included.',
  hybrid: 'Paths, and photons for light by way of mirrors and glass: right in the end.',
  photon_map: 'One reused map and final gather: a preview, biased by what no estimate contains.',
  path: 'Path tracing: unbiased, but slow to find caustics.',
};

/** The job's label, else the name of its scene. */
export function job_title(state: State, job: Job): string {
  return job.label || scene_name(state, job.scene);
}

const kLabelCharacters = 200; // that the server takes

/** As much of a name as the server takes, of a scene and for a job on it. */
export function label_of(name: string): string {
  return [...name].slice(0, kLabelCharacters).join('');
}

/** What a picture of this title is called as a file. */
export function file_stem(title: string): string {
  const words = title.replace(/\.\w+$/, '').match(/[\p{L}\p{M}\p{N}-]+/gu) ?? [];
  return [...words.join('_')].slice(0, 60).join('');
}
