import { api, describe, type Answer } from './api';
import { label_of } from './names';
import type { Environment, SceneReport } from './wire';

/** Says how an upload goes; `failed` where it did not work. */
export type Say = (words: string, failed?: boolean) => void;

/** One kind of thing that is uploaded. */
interface Kind<T extends { name: string }> {
  /** Said where several files of the kind come at once. */
  one_only: string;
  /** `name`: what it is to be called. */
  send(file: File, name: string): Promise<Answer<T>>;
}

export const kScenes: Kind<SceneReport> = {
  one_only: 'Give one scene at a time; a .gltf with the files it refers to as one zip.',
  send: (file, name) => api.upload(file, media_type_of(file.name), name),
};

export const kEnvironments: Kind<Environment> = {
  one_only: 'Give one picture of the surroundings at a time.',
  send: (file, name) => api.upload_environment(file, name),
};

/** Whether a file of this name is a picture of the surroundings rather than a scene. */
export function is_environment({ name }: File): boolean {
  return /\.(exr|hdr)$/i.test(name);
}

/** Sends the only one of `files`, of at most `limit` bytes, and says how it goes; null where nothing came of it. */
export async function upload<T extends { name: string }>(
  files: File[], kind: Kind<T>, limit: number | null, say: Say,
): Promise<T | null> {
  const [file, ...more] = files;
  if (!file) return null;
  const refused = more.length > 0 ? kind.one_only : await fault_of(file, limit);
  if (refused) {
    say(refused, true);
    return null;
  }
  say(`Sending ${file.name} …`);
  const name = label_of(file.name);
  const answer = await kind.send(file, name);
  if (!answer.ok) {
    say(`${file.name}: ${describe(answer.failure)}`, true);
    return null;
  }
  const known = answer.value.name;
  say(`${file.name} is ready${known === name ? '' : `; it is known as ${known}`}.`);
  return answer.value;
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
