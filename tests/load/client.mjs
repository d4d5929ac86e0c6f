// Requests as the load test makes them: one connection each, as photond serves them, or kept open through a proxy.
import { request as http_request } from 'node:http';
import { connect } from 'node:net';

/** One request; resolves to { status, headers, body, ms }, the time from before the connection to the last byte. */
export function call(port, method, path, { body, headers = {}, timeout_ms = 30_000 } = {}) {
  return new Promise((resolve, reject) => {
    const begin = performance.now();
    const type = typeof body === 'object' && !Buffer.isBuffer(body) ? { 'Content-Type': 'application/json' } : {};
    const bytes = body === undefined ? undefined : Buffer.isBuffer(body) ? body : Buffer.from(JSON.stringify(body));
    const length = bytes ? { 'Content-Length': bytes.length } : {};
    const request = http_request(
      { host: '127.0.0.1', port, method, path, agent: false, timeout: timeout_ms, headers: { ...type, ...length, ...headers } },
      (response) => {
        const chunks = [];
        response.on('data', (chunk) => chunks.push(chunk));
        response.on('error', reject);
        response.on('end', () =>
          resolve({
            status: response.statusCode,
            headers: response.headers,
            body: Buffer.concat(chunks),
            ms: performance.now() - begin,
          }),
        );
      },
    );
    request.on('timeout', () => request.destroy(new Error(`${method} ${path}: no answer in ${timeout_ms} ms`)));
    request.on('error', reject);
    request.end(bytes);
  });
}

export const json = (reply) => JSON.parse(reply.body.toString());

/** Submits a job of a sample scene; resolves to the reply. */
export async function submit(port, fields, headers = {}) {
  const scenes = json(await call(port, 'GET', '/v1/scenes', { headers })).scenes;
  const scene = scenes.find((one) => one.name === 'cornell_box').id;
  return call(port, 'POST', '/v1/jobs', { body: { scene, ...fields }, headers });
}

/** Follows an event stream: `hear(event, milliseconds)` for each, by the wall clock of its arrival. */
export class Viewer {
  constructor(port, path, hear, headers = {}) {
    this.text = '';
    this.socket = connect(port, '127.0.0.1');
    this.opened = new Promise((resolve, reject) => {
      this.socket.once('data', resolve);
      this.socket.once('error', reject);
      this.socket.once('close', () => reject(new Error('the stream was closed before it began')));
    });
    const lines = Object.entries({ Host: '127.0.0.1', Accept: 'text/event-stream', ...headers }).map(([name, value]) => `${name}: ${value}\r\n`);
    this.socket.write(`GET ${path} HTTP/1.1\r\n${lines.join('')}\r\n`);
    this.socket.setEncoding('utf8');
    this.socket.on('data', (chunk) => {
      this.status ??= Number(chunk.slice(9, 12));
      const now = Date.now();
      this.text += chunk;
      const blocks = this.text.split('\n\n');
      this.text = blocks.pop();
      for (const block of blocks) {
        const name = /^event: (.*)$/m.exec(block)?.[1];
        const data = /^data: (.*)$/m.exec(block)?.[1];
        if (name) hear({ name, ...JSON.parse(data) }, now);
      }
    });
    this.socket.on('error', () => {});
  }
  close() {
    this.socket.destroy();
  }
}
