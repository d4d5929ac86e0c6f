import { mkdirSync } from 'node:fs';
import type { BrowserContext, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, expect } from 'vitest';
import { launch, open_page } from './page';
import { kPictures, start_photond, type Photond } from './photond';

/** A service and a browser for all tests of a file. */
export let photond: Photond;
export let context: BrowserContext;
/** Its page, a new one for each test. */
export let page: Page;

let expected: RegExp[];

/** The errors that a test provokes: browsers log every answer that is not 2xx. All others fail it. */
export function expect_errors(...patterns: RegExp[]): void {
  expected = patterns;
}

/** Starts and ends the service and the browser. */
export function use_service(): void {
  let close_browser: () => Promise<void>;

  beforeAll(async () => {
    mkdirSync(kPictures, { recursive: true });
    photond = await start_photond();
    ({ context, close: close_browser } = await launch());
  });

  afterAll(async () => {
    await close_browser?.();
    await photond?.stop();
  });
}

/** The same with a page for each test. */
export function use_page(): void {
  use_service();
  let errors: string[];

  beforeEach(async () => {
    expected = [];
    ({ page, errors } = await open_page(context, photond.url));
  });

  afterEach(async () => {
    await page.close();
    expect(errors.filter((error) => !expected.some((pattern) => pattern.test(error)))).toEqual([]);
  });
}
