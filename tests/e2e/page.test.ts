import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, expect, it } from 'vitest';
import { a_sample, with_generator } from './support/glb';
import { drop, shown, shown_where, start_job, wait_for_state } from './support/page';
import { jobs_of, kPictures, start_photond } from './support/photond';
import { expect_errors, page, photond, use_page } from './support/session';

use_page();

async function download(selector: string): Promise<{ name: string; bytes: Buffer }> {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(selector)]);
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

async function cancel(): Promise<void> {
  await page.click('#cancel');
  await wait_for_state(page, 'canceled', 5_000);
}

describe('a picture', () => {
  it('is made of a dropped GLB, refines, and is downloaded', async () => {
    await drop(page, { name: 'mine.glb', bytes: with_generator(a_sample(), 'photond e2e') });
    await page.getByText('mine.glb is ready.').waitFor();
    expect(await page.locator('#scene option:checked').textContent()).toBe('mine.glb');
    expect(await page.textContent('#report-counts')).toMatch(/\d triangles?, \d+ materials?/);

    const job = await start_job(page, { width: 96, height: 64, seconds: 3 });
    const first = await shown_where(page, (picture) => picture.job === job);
    expect(first).toMatchObject({ width: 96, height: 64 });
    expect(first.mean).toBeGreaterThan(0);
    const later = await shown_where(page, (picture) => picture.revision > first.revision);
    expect(later.fingerprint).not.toBe(first.fingerprint);

    await wait_for_state(page, 'succeeded');
    expect(await page.textContent('#job-title')).toBe('mine.glb');
    expect(Number.parseInt(await page.textContent('#passes') ?? '')).toBeGreaterThan(1);
    expect(await page.textContent('#error')).toMatch(/%/);
    expect(await page.locator('#plan-items li').count()).toBeGreaterThan(0);
    expect(await page.locator('#chart .curve').count()).toBe(1);

    const png = await download('#download-png');
    expect(png.name).toBe(`mine-${job}.png`);
    expect(png.bytes.subarray(0, 8).toString('hex')).toBe('89504e470d0a1a0a');
    expect([png.bytes.readUInt32BE(16), png.bytes.readUInt32BE(20)]).toEqual([96, 64]);
    const exr = await download('#download-exr');
    expect(exr.name).toBe(`mine-${job}.exr`);
    expect(exr.bytes.subarray(0, 4).toString('hex')).toBe('762f3101');
  });

  it('shows its error while it refines and when it is done', async () => {
    const job = await start_job(page, { width: 64, height: 64, seconds: 4 });
    const picture = await shown_where(page, (now) => now.job === job && now.view === 'picture');
    await page.click('#show-error');
    const error = await shown_where(page, (now) => now.view === 'error');
    expect(error.revision).toBeGreaterThanOrEqual(picture.revision);
    expect(error.fingerprint).not.toBe(picture.fingerprint);
    expect(await page.locator('#show-error').getAttribute('aria-pressed')).toBe('true');
    expect(await page.textContent('#legend')).toMatch(/95 % bound/);
    await wait_for_state(page, 'succeeded');
    const last = await shown_where(page, (now) => now.revision > error.revision && now.view === 'error');
    expect(last.mean).toBeLessThan(error.mean);   // it falls with the noise
    await page.screenshot({ path: join(kPictures, 'error.png'), fullPage: true });
    await page.click('#show-picture');
    await shown_where(page, (now) => now.view === 'picture' && now.revision === last.revision);
    expect(await page.locator('#legend').isVisible()).toBe(false);
  });

  it('is lit from around by a chosen map, turned and scaled', async () => {
    const plain = await start_job(page, { width: 32, height: 24, passes: 4 });
    const before = await shown_where(page, (picture) => picture.job === plain);
    expect(await page.locator('#environment-rotation').isVisible()).toBe(false);

    const pixels = Buffer.from('80808081'.repeat(8 * 4), 'hex');
    const sky = Buffer.concat([Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'), pixels]);
    await page.setInputFiles('#environment-file', { name: 'sky.hdr', mimeType: '', buffer: sky });
    await page.getByText('sky.hdr is ready.').waitFor();
    expect(await page.locator('#environment option:checked').textContent()).toBe('sky.hdr, 8 × 4');
    await page.fill('#environment-rotation', '90');
    await page.fill('#environment-scale', '3');
    await page.screenshot({ path: join(kPictures, 'environment.png'), fullPage: true });
    const lit = await start_job(page, { width: 32, height: 24, passes: 4 });
    const after = await shown_where(page, (picture) => picture.job === lit);
    expect(after.mean).toBeGreaterThan(before.mean);
    const { spec } = await (await fetch(`${photond.url}v1/jobs/${lit}`)).json() as { spec: { environment: unknown } };
    expect(spec.environment).toMatchObject({ rotation_deg: 90, scale: 3 });

    await page.setViewportSize({ width: 390, height: 844 });
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBe(390);
    await page.screenshot({ path: join(kPictures, 'environment_phone.png'), fullPage: true });
    await page.selectOption('#environment', '');
    expect(await page.locator('#environment-scale').isVisible()).toBe(false);
  });

  it('is taken from elsewhere, beginning where a camera is', async () => {
    expect_errors(/status of 422/);
    await page.selectOption('#scene', { index: 0 });
    await page.selectOption('#camera', 'elsewhere');
    const axes = ['x', 'y', 'z'] as const;
    const [x, y, z] = await Promise.all(axes.map(async (axis) => Number(await page.inputValue(`#camera-eye-${axis}`))));
    expect([x, y, z]).not.toEqual([0, 0, 0]);
    await page.fill('#camera-eye-x', '0.5');
    await page.fill('#camera-angle', '60');
    const job = await start_job(page, { width: 32, height: 24, passes: 2 });
    await shown_where(page, (picture) => picture.job === job);
    const { spec } = await (await fetch(`${photond.url}v1/jobs/${job}`)).json() as { spec: { camera: unknown } };
    expect(spec.camera).toMatchObject({ eye: [0.5, y, z].map((at) => expect.closeTo(at!, 4)), yfov_deg: 60 });
    await page.screenshot({ path: join(kPictures, 'elsewhere.png'), fullPage: true });

    for (const axis of axes) await page.fill(`#camera-target-${axis}`, await page.inputValue(`#camera-eye-${axis}`));
    await page.click('#start');
    await page.locator('#camera-error', { hasText: 'must not be the eye' }).waitFor();
    expect(await page.getAttribute('#camera-target-x', 'aria-invalid')).toBe('true');
    await page.selectOption('#camera', '0');
    expect(await page.locator('#camera-more').isVisible()).toBe(false);
  });

  it('is said at the surroundings when they are not a map of light', async () => {
    expect_errors(/status of 422/);
    await drop(page, { name: 'letter.exr', bytes: Buffer.from('Dear Sir') });
    await page.locator('#environment-status[data-failed="true"]').waitFor();
    expect(await page.textContent('#environment-status')).toMatch(/^letter\.exr: .+\.$/);
  });

  it('ends as the very pixels of the final PNG', async () => {
    const job = await start_job(page, { width: 32, height: 24, passes: 3 });
    await wait_for_state(page, 'succeeded');
    const final = await page.evaluate(async (id) => {
      const response = await fetch(`/v1/jobs/${id}/frames/latest.png`);
      const bitmap = await createImageBitmap(await response.blob());
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      const drawing = canvas.getContext('2d')!;
      drawing.drawImage(bitmap, 0, 0);
      let fingerprint = 0;
      for (const value of drawing.getImageData(0, 0, bitmap.width, bitmap.height).data) {
        fingerprint = (Math.imul(fingerprint, 31) + value) | 0;
      }
      return fingerprint;
    }, job);
    await shown_where(page, (picture) => picture.job === job && picture.fingerprint === final);
  });

  it('is canceled, by keyboard alone', async () => {
    await page.fill('#stop-passes', '');
    await page.fill('#stop-seconds', '60');
    await page.press('#stop-seconds', 'Enter');
    await page.waitForURL(/#job=/);
    const job = new URL(page.url()).hash.slice('#job='.length);
    await shown_where(page, (picture) => picture.job === job);
    await page.focus('#cancel');
    await page.keyboard.press('Enter');
    await wait_for_state(page, 'canceled', 5_000);
    const { state } = await (await fetch(`${photond.url}v1/jobs/${job}`)).json() as { state: string };
    expect(state).toBe('canceled');
    expect(await page.locator('#cancel').isVisible()).toBe(false);
    expect(await page.textContent('#announce')).toMatch(/Canceled/);
  });

  it('keeps the keyboard where it is when a button gives way to another', async () => {
    expect_errors(/status of 503/);
    const focused = () => page.evaluate(() => document.activeElement?.id);
    await start_job(page, { width: 32, height: 24, seconds: 60 });
    await wait_for_state(page, 'rendering');
    for (const [action, state, next] of
      [['pause', 'paused', 'resume'], ['resume', 'rendering', 'pause'], ['cancel', 'canceled', 'job-title']] as const) {
      await page.focus(`#${action}`);
      await page.keyboard.press('Enter');
      await wait_for_state(page, state);
      expect(await focused()).toBe(next);
    }
    await page.route('**/v1/jobs', (route) => route.fulfill({ status: 503, body: 'not now' }));
    await page.focus('#start');
    await page.keyboard.press('Enter');
    await page.locator('#form-error', { hasText: '503' }).waitFor();
    expect(await focused()).toBe('start');
  });

  it('is still watched after a reload, and again from the list', async () => {
    const job = await start_job(page, { width: 64, height: 64, seconds: 60 });
    const before = await shown_where(page, (picture) => picture.job === job);
    await page.reload();
    const after = await shown_where(page, (picture) => picture.job === job && picture.revision >= before.revision);
    await shown_where(page, (picture) => picture.revision > after.revision);
    await page.click('.brand a');
    await expect.poll(() => shown(page)).toBeNull();
    await page.click(`#jobs a[href="#job=${job}"]`);
    await shown_where(page, (picture) => picture.job === job);
    await cancel();
  });

  it('is never replaced by one that comes too late', async () => {
    const slow = await start_job(page, { width: 48, height: 48, passes: 2 });
    await wait_for_state(page, 'succeeded');
    await shown_where(page, (picture) => picture.job === slow);
    const quick = await start_job(page, { width: 32, height: 32, passes: 2 });
    await wait_for_state(page, 'succeeded');
    await page.click('.brand a');

    let asked = 0;
    let answered = 0;
    await page.route(`**/jobs/${slow}/frames/**`, async (route) => {
      ++asked;
      const response = await route.fetch();
      await new Promise((resolve) => setTimeout(resolve, 700));
      await route.fulfill({ response }).catch(() => undefined); // the page may have given up on it
      ++answered;
    });
    await page.click(`#jobs a[href="#job=${slow}"]`);
    await expect.poll(() => asked).toBe(1);
    await page.click(`#jobs a[href="#job=${quick}"]`);
    await shown_where(page, (picture) => picture.job === quick);
    await expect.poll(() => answered).toBe(1);
    await page.waitForTimeout(100);
    expect(await shown(page)).toMatchObject({ job: quick, width: 32 });
  });
});

describe('the list of jobs', () => {
  it('goes back as far as the server does', async () => {
    const { scenes } = await (await fetch(`${photond.url}v1/scenes`)).json() as { scenes: { id: string }[] };
    const spec = { scene: scenes[0]!.id, film: { width: 4, height: 4 }, photons_per_pass: 100, stop: { passes: 1 } };
    for (let number = 0; number < 51; ++number) {
      const body = JSON.stringify({ ...spec, label: `small ${number}` });
      const headers = { 'Content-Type': 'application/json' };
      expect((await fetch(`${photond.url}v1/jobs`, { method: 'POST', body, headers })).status).toBe(202);
    }
    // Those that still run would come into the list as events tell of them.
    const unfinished = async () => (await jobs_of(photond)).filter(({ label, state }) => label.startsWith('small ') && state !== 'succeeded');
    await expect.poll(unfinished, { timeout: 20_000 }).toEqual([]);
    await page.reload();
    const titles = () => page.locator('#jobs a').allTextContents();
    await expect.poll(async () => (await titles()).length).toBe(50);
    await page.click('#older');
    await expect.poll(async () => (await titles()).filter((title) => title.startsWith('small '))).toHaveLength(51);
    const oldest = (await titles()).slice(48, 51).map((title) => /^small \d+/.exec(title)?.[0]);
    expect(oldest).toEqual(['small 2', 'small 1', 'small 0']);
    expect(await page.locator('#older').isVisible()).toBe(false);
  });
});

describe('what goes wrong', () => {
  it('is said at the field', async () => {
    expect_errors(/status of 422/);
    await page.fill('#width', '16384');
    await page.fill('#height', '16384');
    await page.click('#start');
    await page.locator('#film-error').waitFor();
    expect(await page.textContent('#film-error')).toMatch(/pixels/);
    expect(await page.getAttribute('#width', 'aria-invalid')).toBe('true');
    await page.fill('#width', '64');
    expect(await page.locator('#film-error').isVisible()).toBe(false);
  });

  it('is said of a job without an end before it is sent', async () => {
    await page.fill('#stop-passes', '');
    await page.fill('#stop-seconds', '');
    await page.click('#start');
    expect(await page.textContent('#stop-error')).toBe('Give at least one of these.');
  });

  it('is said of a file that is no scene', async () => {
    expect_errors(/status of 422/);
    await page.setInputFiles('#file', { name: 'letter.glb', mimeType: 'model/gltf-binary', buffer: Buffer.from('Dear Sir') });
    await page.locator('#upload-status[data-failed="true"]').waitFor();
    expect(await page.textContent('#upload-status')).toMatch(/^letter\.glb: .+\.$/);
  });

  it('is said of a job that is not there', async () => {
    expect_errors(/status of 404/);
    await page.goto(`${photond.url}#job=j-0`);
    await page.getByText('The server does not know this job').waitFor();
  });

  it('is said of a job that somebody deletes', async () => {
    expect_errors(/status of 404/); // of what was under way
    const job = await start_job(page, { width: 32, height: 32, passes: 2 });
    await wait_for_state(page, 'succeeded');
    await page.locator(`#jobs a[href="#job=${job}"]`).waitFor();
    await fetch(`${photond.url}v1/jobs/${job}`, { method: 'DELETE' });
    await page.getByText('This job has been deleted.').waitFor();
    expect(await page.locator('#job').isVisible()).toBe(false);
    expect(await page.locator(`#jobs a[href="#job=${job}"]`).count()).toBe(0);
    await page.screenshot({ path: join(kPictures, 'deleted.png'), fullPage: true });
  });

  it('is said of a job that cannot go on', async () => {
    expect_errors(/status of 409/);
    await drop(page, { name: 'short.glb', bytes: with_generator(a_sample(), 'to be deleted') });
    await page.getByText('short.glb is ready.').waitFor();
    const job = await start_job(page, { width: 32, height: 32, passes: 2 });
    await wait_for_state(page, 'succeeded');
    const { scene } = await (await fetch(`${photond.url}v1/jobs/${job}`)).json() as { scene: string };
    await fetch(`${photond.url}v1/scenes/${scene}`, { method: 'DELETE' });
    await page.click('#extend');
    await page.locator('#notice', { hasText: 'The job cannot go on: there is no scene' }).waitFor();
  });

  it('is said of a server that is away, until it is back', async () => {
    expect_errors(/net::ERR_|status of 404/);  // which net error depends on what was under way when it went
    const own = await start_photond();
    await page.goto(own.url);
    await page.locator('#server[data-server="online"]').waitFor();
    const job = await start_job(page, { width: 32, height: 32, passes: 2 });
    await shown_where(page, (picture) => picture.job === job);
    await wait_for_state(page, 'succeeded');
    await own.stop();
    await page.getByText('No connection to the server').waitFor();
    await page.click('#extend');
    await page.locator('#notice', { hasText: 'The server does not answer.' }).waitFor();
    await page.click('#start');
    await page.locator('#form-error', { hasText: 'The server does not answer.' }).waitFor();
    const again = await start_photond(own.port);
    try {
      await page.locator('#server[data-server="online"]').waitFor({ timeout: 15_000 });
      await page.locator('#notice').waitFor({ state: 'hidden' });
      await page.getByText('The server does not know this job').waitFor(); // the new process has an empty memory
    } finally {
      await page.goto('about:blank');
      await again.stop();
    }
  });
});

describe('the look', () => {
  const has_scroll = () => page.evaluate(() => document.documentElement.scrollWidth > document.documentElement.clientWidth);

  it('is whole at a phone\'s width, light and dark', async () => {
    await page.screenshot({ path: join(kPictures, 'empty.png') });
    const job = await start_job(page, { width: 200, height: 150, passes: 12 });
    await wait_for_state(page, 'succeeded');
    await shown_where(page, (picture) => picture.job === job);
    await page.screenshot({ path: join(kPictures, 'light.png'), fullPage: true });
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await ground();
    await page.emulateMedia({ colorScheme: 'dark' });
    expect(await ground()).not.toBe(light);
    await page.screenshot({ path: join(kPictures, 'dark.png'), fullPage: true });
    await page.setViewportSize({ width: 360, height: 740 });
    await page.click('#more summary');
    expect(await has_scroll()).toBe(false);
    await page.screenshot({ path: join(kPictures, 'phone_dark.png'), fullPage: true });
    await page.emulateMedia({ colorScheme: 'light' });
    await page.screenshot({ path: join(kPictures, 'phone_light.png'), fullPage: true });
  });

  it('breaks no word on a button, however narrow', async () => {
    await start_job(page, { width: 32, height: 24, seconds: 60 });
    await page.locator('#download-png').waitFor();
    await page.setViewportSize({ width: 320, height: 640 });
    const lines = await page.locator('.actions > :not([hidden])').evaluateAll((buttons) => buttons.map((button) => {
      const words = document.createRange();
      words.selectNodeContents(button);
      return words.getClientRects().length;
    }));
    expect(lines).toEqual([1, 1, 1, 1]);
    expect(await has_scroll()).toBe(false);
    await page.screenshot({ path: join(kPictures, 'narrow.png'), fullPage: true });
    await cancel();
  });
});
