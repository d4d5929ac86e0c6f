import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

const in_modules = (name: string) => fileURLToPath(new URL(`node_modules/${name}`, import.meta.url));

// The tests live beside those of the other parts, outside of the folder that holds node_modules.
export default defineConfig({
  cacheDir: in_modules('.vite'),
  root: fileURLToPath(new URL('..', import.meta.url)),
  resolve: { alias: { 'playwright-core': in_modules('playwright-core/index.mjs'), vitest: in_modules('vitest') } },
  server: { fs: { strict: false } },
  test: {
    include: ['tests/e2e/**/*.test.ts'],
    testTimeout: 60_000,
    hookTimeout: 30_000,
    fileParallelism: false,
  },
});
