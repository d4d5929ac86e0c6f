// Debian's nginx with docker/nginx.conf in front of photond, attacked: node nginx.mjs PHOTOND SAMPLES NGINX_CONF
// Of the configuration only addresses and paths are changed.
import { execFileSync, spawn } from 'node:child_process';
import { chmod, mkdir, mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { connect as http2_connect } from 'node:http2';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { connect } from 'node:tls';
import { json, submit } from './client.mjs';
import { Figures, quantile, sleep } from './figures.mjs';
import { Server } from './server.mjs';

const nginx_program = '/usr/sbin/nginx';

const free_port = () =>
  new Promise((resolve) => {
    const probe = createServer().listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });

class Nginx {
  static async start(template, upstream_port) {
    const folder = await mkdtemp(join(tmpdir(), 'photond-nginx-'));
    await chmod(folder, 0o755);
    await mkdir(join(folder, 'temporary'));
    const port = await free_port();
    execFileSync('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=localhost',
      '-keyout', join(folder, 'key.pem'), '-out', join(folder, 'certificate.pem')], { stdio: 'ignore' });
    const temporary = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((kind) => `${kind}_temp_path ${folder}/temporary/${kind};`);
    const changes = [
      ['listen 8443 ', `listen 127.0.0.1:${port} `],
      ['server photond:8080;', `server 127.0.0.1:${upstream_port};`],
      ['/etc/nginx/tls/', `${folder}/`],
      ['http {', `http {\n  ${temporary.join('\n  ')}`],
    ];
    let text = await readFile(template, 'utf8');
    for (const [from, to] of changes) {
      if (!text.includes(from)) throw new Error(`nginx.conf has no '${from}'`);
      text = text.replaceAll(from, to);
    }
    await writeFile(join(folder, 'nginx.conf'), text);
    const globals = `daemon off; pid ${folder}/pid; error_log ${folder}/error.log; user root;`;
    const child = spawn(nginx_program, ['-p', folder, '-c', join(folder, 'nginx.conf'), '-e', join(folder, 'error.log'), '-g', globals], { stdio: 'inherit' });
    const nginx = Object.assign(new Nginx(), { child, folder, port });
    nginx.ended = new Promise((resolve) => child.once('exit', (code) => resolve(code)));
    for (let i = 0; i < 100; ++i) {
      if ((await status_of(port, get('/healthz')).catch(() => 0)) === 200) return nginx;
      await sleep(50);
    }
    throw new Error(`nginx does not answer: ${await readFile(join(folder, 'error.log'), 'utf8')}`);
  }

  async stop() {
    this.child.kill('SIGTERM');
    await this.ended;
    await rm(this.folder, { recursive: true, force: true });
  }
}

const get = (path, lines = '') => `GET ${path} HTTP/1.1\r\nHost: localhost\r\n${lines}Connection: close\r\n\r\n`;
const post = (path, lines, body) => `POST ${path} HTTP/1.1\r\nHost: localhost\r\n${lines}Connection: close\r\n\r\n${body}`;

/** A TLS connection from an address of its own. */
function open(port, from = '127.0.0.1') {
  const socket = connect({ host: '127.0.0.1', port, localAddress: from, rejectUnauthorized: false, ALPNProtocols: ['http/1.1'] });
  socket.on('error', () => {});
  return socket;
}

/** Sends raw bytes; resolves to everything that comes until the end. */
function ask(port, raw, from) {
  return new Promise((resolve) => {
    const socket = open(port, from);
    let text = '';
    socket.setEncoding('latin1');
    socket.on('data', (chunk) => (text += chunk));
    socket.on('close', () => resolve(text));
    socket.setTimeout(20_000, () => socket.destroy());
    socket.write(raw);
  });
}

const status_in = (text) => Number(/^HTTP\/1\.1 (\d+)/.exec(text)?.[1] ?? 0);
const status_of = async (port, raw, from) => status_in(await ask(port, raw, from));
const answers_in = (text) => text.match(/^HTTP\/1\.1 /gm)?.length ?? 0;

const hidden = get('/v1/info');
const job = 'Content-Type: application/json\r\n';
const scene = 'Content-Type: model/gltf-binary\r\n';

/** Requests that must be refused, and by which statuses. */
const attacks = {
  'a chunked body beyond the limit': [post('/v1/jobs', `${job}Transfer-Encoding: chunked\r\n`, `${'1000\r\n' + 'x'.repeat(4096) + '\r\n'}`.repeat(40)), [413]],
  'a long body': [post('/v1/jobs', `${job}Content-Length: 100000\r\n`, 'x'.repeat(100_000)), [413]],
  'a scene of a gigabyte': [post('/v1/scenes', `${scene}Content-Length: 1000000000\r\n`, 'x'), [413]],
  'a gzip body': [post('/v1/jobs', `${job}Content-Encoding: gzip\r\nContent-Length: 3\r\n`, 'abc'), [415]],
  'two lengths': [post('/v1/jobs', `${job}Content-Length: 2\r\nContent-Length: 3\r\n`, '{} '), [400]],
  'a length and chunks': [post('/v1/jobs', `${job}Content-Length: 3\r\nTransfer-Encoding: chunked\r\n`, '0\r\n\r\n'), [400]],
  'an unknown transfer coding': [post('/v1/jobs', `${job}Transfer-Encoding: chunked, identity\r\n`, '0\r\n\r\n'), [400, 501]],
  '200,000 headers': [`GET / HTTP/1.1\r\nHost: localhost\r\n${'A: 1\r\n'.repeat(200_000)}\r\n`, [400, 431]],
  'an endless header': [`GET / HTTP/1.1\r\nHost: localhost\r\nA: ${'a'.repeat(1_000_000)}`, [400, 431]],
  'an endless path': [`GET /${'a'.repeat(1_000_000)}`, [414]],
  'a path out of the root': [get('/../../etc/passwd'), [400]],
  'the same, encoded': [get('/%2e%2e/%2e%2e/etc/passwd'), [400]],
  'a NUL in the path': [get('/v1/info%00'), [400]],
  'a line feed in the path': [get('/v1/jobs%0d%0aX-Evil:%201'), [400]],
  'the metrics': [get('/metrics'), [404]],
};

async function refusals({ port, figures }) {
  for (const [what, [raw, statuses]] of Object.entries(attacks)) {
    const status = await status_of(port, raw);
    figures.exactly(`nginx: ${what} is refused`, statuses.includes(status) ? status : `not by ${statuses}: ${status}`, status);
  }
}

async function smuggling({ port, figures }) {
  const raws = [
    post('/v1/jobs/none/cancel', `Content-Length: ${hidden.length}\r\n`, hidden),
    post('/v1/jobs', `${job}Content-Length: 0\r\nTransfer-Encoding: chunked\r\n`, `0\r\n\r\n${hidden}`),
    post('/v1/jobs', `${job}Transfer-Encoding : chunked\r\n`, `0\r\n\r\n${hidden}`),
    get('/healthz', `Content-Length: ${hidden.length}\r\n`) + hidden,
  ];
  const texts = await Promise.all(raws.map((raw) => ask(port, raw)));
  figures.exactly('nginx: hidden requests answered', texts.filter((text) => answers_in(text) !== 1 || text.includes('max_upload_bytes')).length, 0);
}

async function headers({ port, figures }) {
  const text = await ask(port, get('/healthz', 'X-Request-Id: chosen-by-client\r\nREMOTE_ADDR: 6.6.6.6\r\n'));
  figures.exactly('nginx: HSTS is announced', text.includes('Strict-Transport-Security:'), true);
  figures.exactly('nginx: the request id is its own', /X-Request-Id: [0-9a-f]{32}\r\n/i.test(text), true);
  figures.exactly('nginx: its version stays its own', /Server: nginx\r\n/.test(text), true);
}

async function slow_loris({ port, figures }) {
  const crowd = Array.from({ length: 500 }, (_, i) => {
    const socket = open(port, `127.0.0.${2 + (i % 8)}`);
    socket.write(i % 2 ? 'GET /healthz HTTP/1.1\r\nX: ' : post('/v1/jobs', `${job}Content-Length: 60000\r\n`, '{'));
    const timer = setInterval(() => socket.write('a'), 1000);
    socket.on('close', () => clearInterval(timer));
    return socket;
  });
  await sleep(2000);
  const times = [];
  for (let i = 0; i < 200; ++i) {
    const begin = performance.now();
    if ((await status_of(port, get('/healthz'))) === 200) times.push(performance.now() - begin);
    await sleep(25);
  }
  figures.exactly('nginx: of 200 health requests under 500 slow-loris clients served', times.length, 200);
  figures.note('nginx: their p99, a TLS handshake each', `${quantile(times, 0.99).toFixed(1)} ms`);
  await sleep(8000);
  const left = (heads) => crowd.filter((socket, i) => (i % 2 === 1) === heads && !socket.destroyed).length;
  figures.exactly('nginx: of them still sending a head after 15 s', left(true), 0);
  // nginx limits the time between two reads of a body, not the whole; they count as connections of their address.
  figures.note('nginx: of them still sending a body', left(false));
  crowd.forEach((socket) => socket.destroy());
}

async function limits({ port, figures }) {
  const flood = await Promise.all(Array.from({ length: 400 }, () => status_of(port, get('/healthz'), '127.0.0.20')));
  figures.exactly('nginx: a flood from one address hears 429', flood.some((status) => status === 429), true);
  figures.exactly('nginx: … and nothing but 200 and 429', flood.every((status) => status === 200 || status === 429), true);
  figures.exactly('nginx: another address is served meanwhile', await status_of(port, get('/healthz'), '127.0.0.21'), 200);
  const streams = Array.from({ length: 80 }, () => {
    const socket = open(port, '127.0.0.22');
    socket.write('GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n');
    socket.once('data', (chunk) => (socket.heard = status_in(chunk.toString('latin1'))));
    return socket;
  });
  await sleep(2000);
  const heard = streams.map((socket) => socket.heard);
  streams.forEach((socket) => socket.destroy());
  figures.exactly('nginx: streams of one address', heard.filter((status) => status === 200).length, 64);
  figures.exactly('nginx: refused ones', heard.filter((status) => status === 429).length, 16);
}

/** Eight uploads at once, whoever else looks on from the same address. */
async function busy_address({ port, figures }) {
  const from = '127.0.0.23';
  const begin = (raw) => {
    const socket = open(port, from);
    socket.write(raw);
    socket.once('data', (chunk) => (socket.heard = status_in(chunk.toString('latin1'))));
    return socket;
  };
  const viewers = Array.from({ length: 12 }, () => begin('GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n'));
  await sleep(500);
  figures.exactly('nginx: scenes listed beside 12 viewers of one address', await status_of(port, get('/v1/scenes'), from), 200);
  const uploading = Array.from({ length: 10 }, () => begin(post('/v1/scenes', `${scene}Content-Length: 100000\r\n`, 'x')));
  await sleep(500);
  figures.exactly('nginx: uploads of one address refused, of 10 at once', uploading.filter((socket) => socket.heard === 429).length, 2);
  figures.exactly('nginx: scenes listed beside uploads', await status_of(port, get('/v1/scenes'), from), 200);
  [...viewers, ...uploading].forEach((socket) => socket.destroy());
}

async function streams({ port, photond_port, figures }) {
  const { id } = json(await submit(photond_port, { film: { width: 64, height: 64 }, method: 'path', stop: { seconds: 8 } }));
  const late = [];
  const viewer = open(port);
  let text = '';
  viewer.on('data', (chunk) => {
    text += chunk;
    const now = Date.now();
    for (const time of text.matchAll(/"time":"([^"]+)"/g)) late.push(now - Date.parse(time[1]));
    text = text.slice(text.lastIndexOf('\n') + 1);
  });
  viewer.write(`GET /v1/jobs/${id}/events HTTP/1.1\r\nHost: localhost\r\n\r\n`);
  await sleep(1500);
  late.length = 0;
  await sleep(4000);
  viewer.destroy();
  figures.exactly('nginx: events pass', late.length > 3, true);
  figures.below('nginx: the latest of them', Math.max(...late), 500, ' ms');
  const pictures = await ask(port, get(`/v1/jobs/${id}/stream.mjpg`));
  figures.exactly('nginx: the picture stream passes', status_in(pictures) === 200 && pictures.includes('Content-Type: image/jpeg'), true);
}

async function http2({ port, figures }) {
  const session = http2_connect(`https://127.0.0.1:${port}`, { rejectUnauthorized: false });
  const status = await new Promise((resolve, reject) => {
    session.on('error', reject);
    const stream = session.request({ ':path': '/v1/info' });
    stream.on('response', (fields) => resolve(fields[':status']));
    stream.on('error', reject);
    stream.end();
  });
  session.close();
  figures.exactly('nginx: HTTP/2 is spoken', status, 200);
}

async function uploads({ port, figures }) {
  const body = 'x'.repeat(1 << 20);
  figures.exactly('nginx: an upload of a megabyte reaches photond (422: no scene)', await status_of(port, post('/v1/scenes', `${scene}Content-Length: ${body.length}\r\n`, body)), 422);
}

const [photond, samples, template] = process.argv.slice(2);
setTimeout(() => process.exit(1), 180_000).unref(); // whatever hangs
const figures = new Figures();
const server = await Server.start({ photond, samples });
process.on('exit', () => server.child.kill('SIGKILL'));
const nginx = await Nginx.start(template, server.port);
process.on('exit', () => nginx.child.kill('SIGTERM'));
for (const check of [refusals, smuggling, headers, uploads, http2, busy_address, streams, limits, slow_loris]) {
  await check({ port: nginx.port, photond_port: server.port, figures });
}
await nginx.stop();
await server.stop();
process.stdout.write(`${figures.markdown()}\n`);
process.exit(figures.missed.length ? 1 : 0);
