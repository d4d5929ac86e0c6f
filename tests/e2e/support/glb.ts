import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { kSamples } from './photond';

const kHeaderBytes = 12;

/** The first of the sample scenes. */
export function a_sample(): Buffer {
  const name = readdirSync(kSamples).filter((file) => file.endsWith('.glb')).sort()[0];
  if (!name) throw new Error(`there is no sample in ${kSamples}`);
  return readFileSync(join(kSamples, name));
}

/** The same scene with another `asset.generator`: a file that the service has never seen. */
export function with_generator(glb: Buffer, generator: string): Buffer {
  const json_bytes = glb.readUInt32LE(kHeaderBytes);
  const json_end = kHeaderBytes + 8 + json_bytes;
  const document = JSON.parse(glb.subarray(kHeaderBytes + 8, json_end).toString());
  document.asset.generator = generator;
  const text = Buffer.from(JSON.stringify(document));
  const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const head = Buffer.from(glb.subarray(0, kHeaderBytes + 8));
  head.writeUInt32LE(json.length, kHeaderBytes);
  head.writeUInt32LE(glb.length - json_bytes + json.length, 8);
  return Buffer.concat([head, json, glb.subarray(json_end)]);
}
