import { api, describe, type Answer } from './api';
import type { Environment, SceneReport } from './wire';

/** Says how an upload goes; `failed` where it did not work. */
export type Say = (words: string, failed?: boolean) => void;

/** One kind of thing that is uploaded. */
interface Kind<T> {
  /** Said where several files of the kind come at once. */
  one_only: string;
  send(file: File): Promise<Answer<T>>;
}

export const kScenes: Kind<SceneReport> = {
  one_only: 'Give one scene at a time; a .gltf with the files it refers to as one zip.',
  send: (file) => api.upload(file, media_type_of(file.name)),
};

export const kEnvironments: Kind<Environment> = {
  one_only: 'Give one picture of the surroundings at a time.',
  send: (file) => api.upload_environment(file),
};

/** Whether a file of this name is a picture of the surroundings rather than a scene. */
export function is_environment({ name }: File): boolean {
  return /\.(exr|hdr)$/i.test(name);
}

/** Sends the only one of `files`, of at most `limit` bytes, and says how it goes; null where nothing came of it. */
export async function upload<T>(files: File[], kind: Kind<T>, limit: number | null, say: Say): Promise<T | null> {
  const [file, ...more] = files;
  if (!file) return null;
  const refused = more.length > 0 ? kind.one_only : await fault_of(file, limit);
  if (refused) {
    say(refused, true);
    return null;
  }
  say(`Sending ${file.name} …`);
  const answer = await kind.send(file);
  if (answer.ok) say(`${file.name} is ready.`);
  else say(`${file.name}: ${describe(answer.failure)}`, true);
  return answer.ok ? answer.value : null;
}

/** Why the file cannot be sent, or would not be taken. */
async function fault_of(file: File, limit: number | null): Promise<string | null> {
  if (limit !== null && file.size > limit) return `${file.name} is larger than the server accepts.`;
  try {
    await file.slice(0, 1).arrayBuffer();
    return null;
  } catch {
    return `${file.name} cannot be read; is it a folder, or gone?`;
  }
}

function media_type_of(name: string): string {
  if (/\.zip$/i.test(name)) return 'application/zip';
  return /\.gltf$/i.test(name) ? 'model/gltf+json' : 'model/gltf-binary';
}
