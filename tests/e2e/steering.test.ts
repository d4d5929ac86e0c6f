import { join } from 'node:path';
import { describe, expect, it } from 'vitest';
import { open_page, shown_where, start_job, wait_for_state } from './support/page';
import { jobs_of, kPictures } from './support/photond';
import { context, expect_errors, page, photond, use_page } from './support/session';

use_page();

describe('steering', () => {
  /** Where a job's picture is taken from; the place of another one by its name. */
  async function camera_of(job: string): Promise<{ eye: number[]; target: number[] }> {
    const { spec } = await (await fetch(`${photond.url}v1/jobs/${job}`)).json() as { spec: { camera: never } };
    return spec.camera;
  }

  async function drag(right: number, down: number, steps: number): Promise<void> {
    const box = (await page.locator('#picture').boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= steps; ++i) {
      await page.mouse.move(x + right * box.height * i / steps, y + down * box.height * i / steps);
      await page.waitForTimeout(60);
    }
    await page.mouse.up();
  }

  /** Of the jobs on the way nothing is left but the one that is watched. */
  async function nothing_between(first: string, last: string): Promise<void> {
    const others = async () => {
      const ids = (await jobs_of(photond)).map(({ id }) => id);   // the newest first
      return ids.slice(0, ids.indexOf(first)).filter((id) => id !== last);
    };
    await expect.poll(others, { timeout: 5_000 }).toEqual([]);
    const rows = page.locator('#jobs a').evaluateAll((links) => links.map((link) => link.getAttribute('href')));
    expect((await rows).slice(0, 2)).toEqual([`#job=${last}`, `#job=${first}`]);
  }

  const watched = () => new URL(page.url()).hash.slice('#job='.length);
  const distance = ({ eye, target }: { eye: number[]; target: number[] }) =>
    Math.hypot(...eye.map((value, axis) => value - target[axis]!));

  it('turns the camera by a drag, leaves no jobs behind, and leads back', async () => {
    await page.selectOption('#scene', { index: 0 });
    await page.selectOption('#camera', '0');
    const first = await start_job(page, { width: 96, height: 64, seconds: 20 });
    const before = await shown_where(page, (picture) => picture.job === first);
    await page.locator('#steering').waitFor();

    await drag(0.25, 0.05, 12);
    const last = await shown_where(page, (picture) => picture.job === watched() && picture.job !== first);
    expect(last.fingerprint).not.toBe(before.fingerprint);
    await page.waitForTimeout(500);
    const job = watched();
    const camera = await camera_of(job);
    const at = await Promise.all(['x', 'y', 'z'].map(async (axis) => Number(await page.inputValue(`#camera-eye-${axis}`))));
    at.forEach((value, axis) => expect(value).toBeCloseTo(camera.eye[axis]!, 4));
    expect(await page.inputValue('#camera')).toBe('elsewhere');
    // A quarter of the height is an eighth of a turn, to the left; and a little up.
    const [x, y, z] = camera.eye.map((value, axis) => value - camera.target[axis]!) as [number, number, number];
    expect(Math.atan2(x, z)).toBeCloseTo(-Math.PI / 4, 2);
    expect(y / distance(camera)).toBeCloseTo(Math.sin(0.05 * Math.PI), 2);
    await page.screenshot({ path: join(kPictures, 'steered.png'), fullPage: true });

    await nothing_between(first, job);
    await page.goBack();
    expect(watched()).toBe(first);
    await shown_where(page, (picture) => picture.job === first);
    await wait_for_state(page, 'paused');
    await fetch(`${photond.url}v1/jobs/${first}/cancel`, { method: 'POST' });
    await fetch(`${photond.url}v1/jobs/${job}/cancel`, { method: 'POST' });
  });

  it('moves along, goes nearer and turns, by keys and wheel', async () => {
    await page.selectOption('#scene', { index: 0 });
    await page.selectOption('#camera', '0');
    const first = await start_job(page, { width: 48, height: 32, passes: 4 });
    await shown_where(page, (picture) => picture.job === first);
    await page.locator('#steering').waitFor();
    /** What a key or the wheel has led to. */
    const after = async (act: () => Promise<void>) => {
      const now = watched();
      await act();
      await shown_where(page, (picture) => picture.job === watched() && picture.job !== now);
      await page.waitForTimeout(200);
      return camera_of(watched());
    };
    const scrolled = () => page.evaluate(() => scrollY);
    await page.focus('#picture');
    const turned = await after(() => page.keyboard.press('ArrowRight'));
    expect(turned.eye[0]).toBeGreaterThan(turned.target[0]!);
    const nearer = await after(() => page.keyboard.press('+'));
    expect(distance(nearer)).toBeCloseTo(distance(turned) / 1.1, 3);
    const moved = await after(() => page.keyboard.press('Shift+ArrowUp'));
    expect(moved.target[1]).toBeGreaterThan(nearer.target[1]!);
    expect(distance(moved)).toBeCloseTo(distance(nearer), 3);
    const top = await scrolled();
    await page.hover('#picture');
    const farther = await after(() => page.mouse.wheel(0, 100));
    expect(distance(farther)).toBeCloseTo(distance(moved) * 1.1, 3);
    expect(await scrolled()).toBe(top);
  });

  it('takes a click for none, and leads from the error to pictures', async () => {
    const first = await start_job(page, { width: 48, height: 32, passes: 16 });
    await wait_for_state(page, 'succeeded');
    await page.click('#show-error');
    await shown_where(page, ({ job, view }) => job === first && view === 'error');
    const box = (await page.locator('#picture').boundingBox())!;
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + 21, box.y + 20);
    await page.mouse.up();
    await page.waitForTimeout(300);
    expect(watched()).toBe(first);
    await page.keyboard.press('ArrowRight');
    await shown_where(page, ({ job, view }) => job === watched() && job !== first && view === 'picture', 2000);
    expect(await page.getAttribute('#show-picture', 'aria-pressed')).toBe('true');
  });

  it('draws each place on the way, also where its job ends at once', async () => {
    expect_errors(/status of 409/); // of what has ended before it was canceled
    const first = await start_job(page, { width: 48, height: 32, passes: 1 });
    await shown_where(page, ({ job }) => job === first);
    await page.evaluate(() => {
      const canvas = document.querySelector('canvas')!;
      const drawn = new Set<string>();
      new MutationObserver(() => {
        drawn.add(canvas.dataset['job']!);
        document.body.dataset['drawn'] = String(drawn.size);
      }).observe(canvas, { attributeFilter: ['data-job'] });
    });
    await drag(0.25, 0, 16);
    await shown_where(page, ({ job }) => job === watched() && job !== first);
    expect(Number(await page.getAttribute('body', 'data-drawn'))).toBeGreaterThan(4);
    await page.waitForTimeout(500);
    await nothing_between(first, watched());
    await page.goBack();
    expect(watched()).toBe(first);
  });

  it('leaves no jobs in the list of another page either', async () => {
    expect_errors(/status of 409/); // of what has ended before it was canceled
    const first = await start_job(page, { width: 48, height: 32, passes: 1 });
    await shown_where(page, ({ job }) => job === first);
    const { page: other } = await open_page(context, photond.url);
    const rows = other.locator('#jobs a');
    const listed = () => rows.evaluateAll((links) => links.map((link) => link.getAttribute('href')));
    await expect.poll(listed).toContain(`#job=${first}`);
    await page.bringToFront();
    for (let way = 0; way < 3; ++way) await drag(0.25, 0, 16);
    await page.waitForTimeout(500);
    await nothing_between(first, watched());
    const there = (await jobs_of(photond)).map(({ id }) => `#job=${id}`);
    await expect.poll(listed, { timeout: 5_000 }).toEqual(there.slice(0, 50));
    await other.close();
  });

  it('leads nobody back who looks at something else during a drag', async () => {
    const first = await start_job(page, { width: 96, height: 64, seconds: 20 });
    await shown_where(page, ({ job }) => job === first);
    await page.hover('#picture');
    await page.mouse.down();
    const box = (await page.locator('#picture').boundingBox())!;
    for (let i = 1; i <= 10; ++i) await page.mouse.move(box.x + box.width / 2 + 10 * i, box.y + box.height / 2);
    await shown_where(page, ({ job }) => job === watched() && job !== first);
    await page.waitForTimeout(300);
    await page.goBack();
    await shown_where(page, ({ job }) => job === first);
    for (let i = 1; i <= 10; ++i) await page.mouse.move(box.x + 10 * i, box.y + box.height / 2);
    await page.mouse.up();
    await page.waitForTimeout(1000);
    expect(watched()).toBe(first);
    for (const { id, state } of await jobs_of(photond)) {
      if (!['succeeded', 'canceled', 'failed'].includes(state)) await fetch(`${photond.url}v1/jobs/${id}/cancel`, { method: 'POST' });
    }
  });
});
