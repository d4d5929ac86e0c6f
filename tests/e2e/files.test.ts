import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import type { BrowserContext, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, it } from 'vitest';
import { a_sample, with_generator } from './support/glb';
import { drop, drop_path, launch, open_page, start_job, wait_for_state } from './support/page';
import { start_photond, type Photond } from './support/photond';

let photond: Photond;
let context: BrowserContext;
let close_browser: () => Promise<void>;
let page: Page;

beforeAll(async () => {
  photond = await start_photond();
  ({ context, close: close_browser } = await launch());
});

afterAll(async () => {
  await close_browser?.();
  await photond?.stop();
});

beforeEach(async () => void ({ page } = await open_page(context, photond.url)));
afterEach(() => page.close());

/** An even picture of the surroundings, 8 × 4, with a comment that makes it a file of its own. */
function a_sky(comment: string): Buffer {
  const head = `#?RADIANCE\n# ${comment}\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n`;
  return Buffer.concat([Buffer.from(head), Buffer.from('80808081'.repeat(8 * 4), 'hex')]);
}

const kRefused = '#upload-status[data-failed="true"]';

describe('a file', () => {
  it('may have a name longer than a label', async () => {
    const name = `${'long '.repeat(48)}.glb`;
    await drop(page, { name, bytes: with_generator(a_sample(), 'long name') });
    await page.getByText('.glb is ready').waitFor();
    await start_job(page, { width: 16, height: 16, passes: 1 });
    expect(await page.textContent('#job-title')).toBe(name.slice(0, 200));
  });

  it('gives its name, in whatever script, to the pictures that are saved', async () => {
    await drop(page, { name: 'Küche 台所 🎨.v2.glb', bytes: with_generator(a_sample(), 'any script') });
    await page.getByText('.glb is ready').waitFor();
    const job = await start_job(page, { width: 16, height: 16, passes: 1 });
    await wait_for_state(page, 'succeeded');
    const [file] = await Promise.all([page.waitForEvent('download'), page.click('#download-png')]);
    expect(file.suggestedFilename()).toBe(`Küche_台所_v2-${job}.png`);
  });

  it('gives its name to what was uploaded, for everybody and from then on', async () => {
    const [scene, sky] = [with_generator(a_sample(), 'to be named'), a_sky('named')];
    const titles = (list: string) => page.locator(`${list} option`).allTextContents();
    for (const name of ['first', 'second']) {
      await drop(page, { name: `${name}.glb`, bytes: scene }, { name: `${name}.hdr`, bytes: sky });
      await page.locator('#upload-status', { hasText: `${name}.glb is ready` }).waitFor();
      await page.locator('#environment-status', { hasText: `${name}.hdr is ready` }).waitFor();
    }
    expect(await page.textContent('#upload-status')).toBe('second.glb is ready; it is known as first.glb.');
    await page.reload();
    await expect.poll(() => titles('#scene')).toContain('first.glb');
    await expect.poll(() => titles('#environment')).toContain('first.hdr, 8 × 4');
  });

  it('that cannot be read is not blamed on the server', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'photond-e2e-folder-'));
    try {
      await drop_path(page, folder);
      await page.locator(kRefused).waitFor();
      expect(await page.textContent('#upload-status'))
        .toBe(`${basename(folder)} cannot be read; is it a folder, or gone?`);
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  });

  it('of a scene and one of its surroundings are taken at once', async () => {
    const room = with_generator(a_sample(), 'both');
    await drop(page, { name: 'sky.hdr', bytes: a_sky('both') }, { name: 'room.glb', bytes: room });
    await page.getByText('sky.hdr is ready').waitFor();
    await page.getByText('room.glb is ready').waitFor();
  });

  it('that comes with others of its kind is refused with advice', async () => {
    await drop(page, { name: 'room.gltf', bytes: Buffer.from('{}') }, { name: 'room.bin', bytes: Buffer.from('0') });
    await page.locator(kRefused).waitFor();
    expect(await page.textContent('#upload-status')).toMatch(/one scene at a time.*zip/);
  });
});
