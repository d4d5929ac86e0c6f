// Each scenario has a photond of its own, rendering on all cores unless it says otherwise.
import { connect } from 'node:net';
import { Worker } from 'node:worker_threads';
import { Viewer, call, json, submit } from './client.mjs';
import { median, quantile, sleep } from './figures.mjs';

const busy_job = { film: { width: 512, height: 512 }, method: 'path', stop: { seconds: 3600 } };

async function start_rendering(port, headers = {}) {
  const reply = await submit(port, busy_job, headers);
  if (reply.status !== 202) throw new Error(`the job was refused: ${reply.body}`);
  const id = json(reply).id;
  while (json(await call(port, 'GET', `/v1/jobs/${id}`, { headers })).passes < 1) await sleep(50);
  return id;
}

/** Times of /healthz, asked every 20 ms. */
function health_times(port, seconds) {
  return new Promise((resolve, reject) => {
    const worker = new Worker(new URL('./health.mjs', import.meta.url), { workerData: { port, seconds } });
    worker.once('message', resolve);
    worker.once('error', reject);
  });
}

/** A client that sends a byte a second of a request that never ends; shown out, it comes back after a second. */
class Dawdler {
  constructor(port, begin) {
    this.open = () => {
      this.socket = connect(port, '127.0.0.1', () => this.socket.write(begin));
      this.socket.on('error', () => {});
      this.socket.on('data', () => {});
      this.socket.on('close', () => setTimeout(() => !this.done && this.open(), 1000));
    };
    this.open();
    this.timer = setInterval(() => this.socket.write('a'), 1000);
  }
  stop() {
    this.done = true;
    clearInterval(this.timer);
    this.socket.destroy();
  }
}

export async function slow_loris({ start, figures, seconds }) {
  const server = await start();
  await start_rendering(server.port);
  const idle = await health_times(server.port, seconds / 2);
  figures.note('/healthz p99 while rendering, otherwise idle', `${quantile(idle, 0.99).toFixed(2)} ms`);
  const begins = [
    'GET /healthz HTTP/1.1\r\nX: ',
    'POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 60000\r\n\r\n{',
    'POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Type: model/gltf-binary\r\nContent-Length: 9000000\r\n\r\n',
  ];
  const crowd = Array.from({ length: 500 }, (_, i) => new Dawdler(server.port, begins[i % 3]));
  await sleep(1000);
  const times = await health_times(server.port, seconds);
  crowd.forEach((one) => one.stop());
  figures.below('/healthz p99 under 500 slow-loris clients', quantile(times, 0.99), 20, ' ms');
  await server.stop();
}

export async function viewers({ start, figures, seconds }) {
  const server = await start(['--max-streams', '600']);
  const id = await start_rendering(server.port);
  const late = [];
  const hear = (event, now) => late.push(now - Date.parse(event.time));
  const crowd = Array.from({ length: 512 }, (_, i) => new Viewer(server.port, i % 2 ? '/v1/events' : `/v1/jobs/${id}/events`, hear));
  await Promise.all(crowd.map((one) => one.opened));
  late.length = 0; // what was replayed at the beginning is old
  await sleep(seconds * 1000);
  figures.exactly('viewers served of 512', crowd.filter((one) => one.status === 200).length, 512);
  figures.note('events heard', late.length);
  figures.below('event p99 of 512 viewers', quantile(late, 0.99), 250, ' ms');
  crowd.forEach((one) => one.close());
  await server.stop();
}

export async function frames({ start, figures, seconds }) {
  const server = await start();
  const id = await start_rendering(server.port);
  const times = [];
  const fetches = [];
  const crowd = Array.from({ length: 16 }, () => new Viewer(server.port, `/v1/jobs/${id}/events`, (event) => {
    if (event.name !== 'frame') return;
    fetches.push(call(server.port, 'GET', `/v1/jobs/${id}/frames/${event.revision}.jpg`).then((reply) => {
      if (reply.status === 200) times.push(Date.now() - Date.parse(event.time));
    }));
  }));
  await Promise.all(crowd.map((one) => one.opened));
  await Promise.all(fetches);
  times.length = 0;
  await sleep(2 * seconds * 1000);
  await Promise.all(fetches);
  crowd.forEach((one) => one.close());
  figures.note('pictures fetched', times.length);
  figures.below('frame published to JPEG at the client, p95 of 16 viewers', quantile(times, 0.95), 300, ' ms');
  await server.stop();
}

export async function cancel({ start, figures }) {
  const server = await start(['--max-pixels', String(4096 * 4096), '--max-job-memory-mb', '16384']);
  const used_after = async (film, method, watch, stop = { seconds: 600 }, until = '') => {
    const id = json(await submit(server.port, { film, method, stop })).id;
    while (until && json(await call(server.port, 'GET', `/v1/jobs/${id}`)).state !== until) await sleep(5);
    if (until) await sleep(500);
    else if (watch) while ((await call(server.port, 'GET', `/v1/jobs/${id}/frames/latest.jpg?wait=20`)).status !== 200);
    else await sleep(700);
    await call(server.port, 'POST', `/v1/jobs/${id}/cancel`);
    await sleep(1000);
    const before = await server.cpu_seconds();
    await sleep(1000);
    return (await server.cpu_seconds()) - before;
  };
  const used = [];
  for (const method of ['path', 'progressive', 'photon_map']) used.push(await used_after({ width: 1920, height: 1080 }, method));
  figures.below('processor seconds in the second after a cancelled job\'s first, worst of 3 methods', Math.max(...used), 0.05, ' s');
  const large = { width: 4096, height: 4096 };
  figures.below('the same of 4096 × 4096 pixels', await used_after(large, 'path'), 0.05, ' s');
  figures.below('the same, as it finishes', await used_after(large, 'path', false, { passes: 1 }, 'finalizing'), 0.05, ' s');
  figures.below('the same, watched', await used_after(large, 'path', true), 0.05, ' s');
  await server.stop();
}

export async function once({ start, figures }) {
  const server = await start();
  const post = () => submit(server.port, busy_job, { 'Idempotency-Key': 'once' });
  const replies = await Promise.all(Array.from({ length: 64 }, post));
  const polite = replies.filter((reply) => reply.status === 202 || (reply.status === 409 && reply.headers['retry-after']));
  figures.exactly('of 64 identical idempotent posts accepted, or told to ask again', polite.length, 64);
  figures.exactly('jobs made by them', json(await call(server.port, 'GET', '/v1/jobs')).jobs.length, 1);
  await server.stop();
}

/** `count` posts at `rate` a second, whatever becomes of them; resolves to the replies. */
async function flood_of(port, count, rate, post) {
  const begin = performance.now();
  const replies = [];
  for (let i = 0; i < count; ++i) {
    const wait = begin + (i * 1000) / rate - performance.now();
    if (wait > 1) await sleep(wait);
    replies.push(post(i).catch((error) => ({ status: 0, error, ms: Infinity, headers: {} })));
  }
  return Promise.all(replies);
}

export async function flood({ start, figures, flood_count }) {
  const server = await start([], [['--scope', 'submit', '--max-jobs', '200'], ['--scope', 'submit']]);
  const [headers, other] = server.keys.map((key) => ({ Authorization: `Bearer ${key}` }));
  await start_rendering(server.port, headers);
  const scene = json(await call(server.port, 'GET', '/v1/scenes', { headers })).scenes.find((one) => one.name === 'cornell_box').id;
  const body = { scene, film: { width: 64, height: 64 }, method: 'path', stop: { seconds: 600 } };
  const replies = await flood_of(server.port, flood_count, 500, () => call(server.port, 'POST', '/v1/jobs', { body, headers }));
  const counts = {};
  for (const reply of replies) counts[reply.status] = (counts[reply.status] ?? 0) + 1;
  figures.note(`answers to ${flood_count} job posts at 500/s`, JSON.stringify(counts));
  const polite = replies.filter((reply) => reply.status === 202 || ([429, 503].includes(reply.status) && reply.headers['retry-after']));
  figures.exactly('of these accepted or refused with Retry-After', polite.length, flood_count);
  figures.below('answer p99', quantile(replies.map((reply) => reply.ms), 0.99), 50, ' ms');
  const begin = performance.now();
  const accepted = await submit(server.port, body, other);
  figures.exactly("another key's job is accepted", accepted.status, 202);
  const id = json(accepted).id;
  let state = 'queued';
  while (state === 'queued' && performance.now() - begin < 20_000) {
    await sleep(20);
    state = json(await call(server.port, 'GET', `/v1/jobs/${id}`, { headers: other })).state;
  }
  figures.below("another key's job starts within", (performance.now() - begin) / 1000, 2, ' s');
  await server.stop();
}

/** One round of everything that clients do. */
async function round_of(port) {
  const reply = await submit(port, { film: { width: 64, height: 64 }, stop: { passes: 8 } });
  if (reply.status !== 202) return;
  const id = json(reply).id;
  const viewer = new Viewer(port, `/v1/jobs/${id}/events`, () => {});
  await call(port, 'GET', `/v1/jobs/${id}/frames/latest.png?wait=20`);
  if (Math.random() < 0.3) await call(port, 'POST', `/v1/jobs/${id}/cancel`);
  await call(port, 'GET', `/v1/jobs/${id}/frames/latest.exr`);
  await call(port, 'GET', '/metrics');
  viewer.close();
  let state = '';
  while (!['succeeded', 'failed', 'canceled'].includes(state)) {
    state = json(await call(port, 'GET', `/v1/jobs/${id}`)).state;
    await sleep(50);
  }
  await call(port, 'DELETE', `/v1/jobs/${id}`);
}

export async function soak({ start, figures, soak_seconds }) {
  const server = await start(['--map-cache-mb', '64']);
  await round_of(server.port);
  await sleep(6000); // clients are shown out within 5 s
  const files_before = await server.descriptors();
  const end = performance.now() + soak_seconds * 1000;
  let rounds = 0;
  const worker = async () => {
    while (performance.now() < end) {
      await round_of(server.port);
      ++rounds;
    }
  };
  const samples = [];
  const workers = Array.from({ length: 4 }, worker);
  while (performance.now() < end) {
    await sleep(1000);
    samples.push({ bytes: await server.resident_bytes(), files: await server.descriptors() });
  }
  await Promise.all(workers);
  const part = (from, to) => samples.slice(Math.floor(samples.length * from), Math.floor(samples.length * to));
  const early = part(0.25, 0.5); // the first quarter fills the caches
  const late = part(0.75, 1);
  const grown = (key) => median(late.map((one) => one[key])) - median(early.map((one) => one[key]));
  figures.note(`soak of ${soak_seconds} s: rounds`, rounds);
  figures.note('resident memory at its end', `${(late.at(-1).bytes / 2 ** 20).toFixed(0)} MiB`);
  figures.below('growth of resident memory, second quarter to last', grown('bytes') / 2 ** 20, 16, ' MiB');
  figures.below('growth of open descriptors, second quarter to last', grown('files'), 8);
  await sleep(6000);
  figures.below('descriptors left open when all have gone', (await server.descriptors()) - files_before, 8);
  await server.stop();
}
