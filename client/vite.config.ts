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
  // The service refuses changes where Host and Origin differ, so it hears the browser's Host.
  server: {
    proxy: Object.fromEntries(['/v1', '/healthz'].map((path) => [path, { target: service, changeOrigin: false }])),
  },
  test: { include: ['test/**/*.test.ts'] },
});
