import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { BrowserContext } from 'playwright-core';
import { afterAll, beforeAll, expect, it } from 'vitest';
import { launch, shown_where, start_job, wait_for_state } from './support/page';
import { kPictures, kProgram, start_photond, type Photond } from './support/photond';

const data = mkdtempSync(join(tmpdir(), 'photond-e2e-data-'));
let key: string;
let photond: Photond;
let context: BrowserContext;
let close_browser: () => Promise<void>;

beforeAll(async () => {
  key = execFileSync(kProgram, ['key', 'create', '--scope', 'submit', '--data', data], { stdio: ['ignore', 'pipe', 'ignore'] })
    .toString().trim();
  photond = await start_photond(0, ['--data', data]);
  ({ context, close: close_browser } = await launch());
});

afterAll(async () => {
  await close_browser?.();
  await photond?.stop();
  rmSync(data, { recursive: true, force: true });
});

it('asks for a key where the service needs one, and uses it for everything', async () => {
  const page = await context.newPage();
  await page.goto(photond.url);
  const dialog = page.locator('#key-dialog');
  await dialog.waitFor();
  expect(await page.locator('#key-unknown').isVisible()).toBe(false);
  await expect.poll(() => page.locator('#server').textContent()).toBe('The server asks for a key.');
  await page.screenshot({ path: join(kPictures, 'key.png') });

  await page.fill('#key', 'photond_wrong');
  await page.click('#key-form button');
  await page.locator('#key-unknown').waitFor();

  await page.fill('#key', key);
  await page.click('#key-form button');
  await page.locator('#server[data-server="online"]').waitFor();
  expect(await dialog.isVisible()).toBe(false);

  const job = await start_job(page, { width: 32, height: 24, passes: 3 });
  await wait_for_state(page, 'succeeded');
  await shown_where(page, (picture) => picture.job === job && picture.mean > 0);
  const [file] = await Promise.all([page.waitForEvent('download'), page.click('#download-png')]);
  expect(file.suggestedFilename()).toMatch(/\.png$/);
  expect(readFileSync(await file.path()).subarray(1, 4).toString()).toBe('PNG');

  await page.route('**/frames/latest.exr', (route) => route.fulfill({ status: 204 }));
  await page.click('#download-exr');
  await page.getByText('.exr: The server answered 204.').waitFor();
  await page.close();
});
