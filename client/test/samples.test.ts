import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { validateBytes } from 'gltf-validator';
import { describe, expect, it } from 'vitest';

const folder = process.env['PHOTOND_SAMPLES'] ?? fileURLToPath(new URL('../../build/samples', import.meta.url));
const samples = existsSync(folder) ? readdirSync(folder).filter((name) => name.endsWith('.glb')) : [];

if (samples.length === 0) console.warn(`Not validated: there are no sample scenes in ${folder} (cmake's target samples makes them).`);

describe.skipIf(samples.length === 0)('the sample scenes', () => {
  it.each(samples.length > 0 ? samples : ['none'])('%s is valid glTF without warnings', async (name) => {
    const report = await validateBytes(new Uint8Array(readFileSync(join(folder, name))), { uri: name });
    const { numErrors, numWarnings, messages } = report.issues;
    expect({ numErrors, numWarnings }, JSON.stringify(messages, null, 1)).toEqual({ numErrors: 0, numWarnings: 0 });
  });
});
