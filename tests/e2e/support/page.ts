import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium, type BrowserContext, type Page } from 'playwright-core';

const kChromium = process.env['PHOTOND_CHROMIUM'] ?? '/usr/bin/chromium';

/** A browser of its own, with a profile that is deleted at its end. */
export async function launch(): Promise<{ context: BrowserContext; close(): Promise<void> }> {
  const profile = mkdtempSync(join(tmpdir(), 'photond-e2e-'));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: kChromium,
    headless: true,
    viewport: { width: 1280, height: 860 },
    colorScheme: 'light',
    acceptDownloads: true,
    args: [
      ...(process.getuid?.() === 0 ? ['--no-sandbox'] : []),
      '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage',
    ],
  });
  const close = async () => {
    await context.close();
    rmSync(profile, { recursive: true, force: true });
  };
  return { context, close };
}

/** A page that notes every error of its console, its scripts and its content security policy. */
export async function open_page(context: BrowserContext, url: string): Promise<{ page: Page; errors: string[] }> {
  const page = await context.newPage();
  const errors: string[] = [];
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(url);
  await page.locator('#server[data-server="online"]').waitFor();
  return { page, errors };
}

/** Drops files onto the page as a person would. */
export async function drop(page: Page, ...files: { name: string; bytes: Buffer }[]): Promise<void> {
  const sent = files.map(({ name, bytes }) => ({ name, base64: bytes.toString('base64') }));
  const transfer = await page.evaluateHandle((dropped) => {
    const transferred = new DataTransfer();
    for (const { name, base64 } of dropped) {
      transferred.items.add(new File([Uint8Array.from(atob(base64), (char) => char.charCodeAt(0))], name));
    }
    return transferred;
  }, sent);
  await page.dispatchEvent('#stage', 'dragover', { dataTransfer: transfer });
  await page.dispatchEvent('#stage', 'drop', { dataTransfer: transfer });
}

/** Drops a path of this machine, which need not be a file. */
export async function drop_path(page: Page, path: string): Promise<void> {
  const devtools = await page.context().newCDPSession(page);
  const data = { items: [], files: [path], dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop'] as const) {
    await devtools.send('Input.dispatchDragEvent', { type, x: 300, y: 300, data });
  }
  await devtools.detach();
}

/** Which picture the page shows, and a fingerprint of its pixels. */
export interface Shown {
  job: string;
  view: string;
  revision: number;
  width: number;
  height: number;
  fingerprint: number;
  mean: number;
}

/** What is on the canvas; null while there is none. */
export function shown(page: Page): Promise<Shown | null> {
  return page.evaluate(() => {
    const canvas = document.querySelector('canvas');
    if (!canvas || canvas.hidden) return null;
    const { width, height, dataset } = canvas;
    const pixels = canvas.getContext('2d')!.getImageData(0, 0, width, height).data;
    let fingerprint = 0;
    let sum = 0;
    for (const value of pixels) {
      fingerprint = (Math.imul(fingerprint, 31) + value) | 0;
      sum += value;
    }
    const { job = '', view = '', revision = '' } = dataset;
    return { job, view, revision: Number(revision), width, height, fingerprint, mean: sum / pixels.length };
  });
}

/** Waits for a picture that satisfies `wanted`. */
export async function shown_where(page: Page, wanted: (picture: Shown) => boolean, timeout_ms = 20_000): Promise<Shown> {
  const deadline = Date.now() + timeout_ms;
  for (;;) {
    const picture = await shown(page);
    if (picture && wanted(picture)) return picture;
    if (Date.now() > deadline) throw new Error(`no such picture within ${timeout_ms} ms; shown: ${JSON.stringify(picture)}`);
    await page.waitForTimeout(50);
  }
}

export interface Wish {
  width: number;
  height: number;
  passes?: number;
  seconds?: number;
}

/** Fills in the form and starts; resolves to the id of the job that the page then shows. */
export async function start_job(page: Page, wish: Wish): Promise<string> {
  const before = page.url();
  await page.fill('#width', String(wish.width));
  await page.fill('#height', String(wish.height));
  await page.fill('#stop-passes', wish.passes === undefined ? '' : String(wish.passes));
  await page.fill('#stop-seconds', wish.seconds === undefined ? '' : String(wish.seconds));
  await page.click('#start');
  await page.waitForURL((url) => url.href !== before && url.hash.startsWith('#job='));
  return new URL(page.url()).hash.slice('#job='.length);
}

/** Waits until the watched job is said to be in this state. */
export async function wait_for_state(page: Page, state: string, timeout = 20_000): Promise<void> {
  await page.locator(`#job-state[data-state="${state}"]`).waitFor({ timeout });
}
