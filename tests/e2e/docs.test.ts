import { join } from 'node:path';
import { expect, it } from 'vitest';
import { kPictures } from './support/photond';
import { context, photond, use_service } from './support/session';

use_service();

for (const width of [1280, 390]) {
  it(`shows every operation and schema of the contract, ${width} pixels wide`, async () => {
    const page = await context.newPage();
    const errors: string[] = [];
    page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.setViewportSize({ width, height: 900 });
    await page.goto(`${photond.url}docs`);
    const contract = await (await fetch(`${photond.url}v1/openapi.json`)).json();
    await page.locator('#schema-JobSpec').waitFor();
    const shown = await page.locator('main .operation').evaluateAll((cards) => cards.map((card) => card.id));
    const paths: Record<string, Record<string, { operationId: string }>> = contract.paths;
    const told = Object.values(paths).flatMap((methods) => Object.values(methods).map((operation) => operation.operationId));
    expect([...shown].sort()).toEqual([...told].sort());
    expect(await page.locator('main .schema').count()).toBe(Object.keys(contract.components.schemas).length);
    expect(await page.locator('#submitJob').textContent()).toContain('key: submit');
    expect(await page.locator('#schema-JobSpec').textContent()).toContain('whole number, 1 to 16384; default 512');
    const examples = await page.locator('main .operation').evaluateAll((cards) =>
      cards.map((card) => [...card.querySelectorAll('summary')].map((summary) => summary.textContent)));
    for (const titles of examples) expect(new Set(titles).size).toBe(titles.length);
    expect(await page.locator('#schema-Problem details').count()).toBe(1);
    // Every link within the page leads somewhere, and nothing is wider than the page.
    const dead = await page.locator('a[href^="#"]').evaluateAll((links) =>
      links.map((link) => link.getAttribute('href')!.slice(1)).filter((id) => !document.getElementById(id)));
    expect(dead).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBe(width);
    await page.screenshot({ path: join(kPictures, `docs-${width}.png`) });
    await page.close();
    expect(errors).toEqual([]);
  });
}
