import { defineConfig } from 'vitest/config';

// PHOTOND_URL: the service that `npm run dev` passes requests on to.
const service = process.env['PHOTOND_URL'] ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  build: {
    target: 'es2022',
    assetsInlineLimit: 0, // no data: URIs, so that a strict content security policy holds
    modulePreload: { polyfill: false },
    rollupOptions: { input: { index: 'index.html', docs: 'docs.html' } },
  },
  server: { proxy: { '/v1': service, '/healthz': service } },
  test: { include: ['test/**/*.test.ts'] },
});
