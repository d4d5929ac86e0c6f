// How much sooner a picture is seen where the photon maps are there already:
//   node maps_bench.mjs PHOTOND [--rounds N] [--size N] SCENE.glb...
// Starts services of its own on a folder of its own. For each scene, in turns: a cold service (no maps), another camera
// on the warm one, a third camera after a restart, and a restart without maps. Each time is from the sending of the job
// to the last byte of the first picture as JPEG. Prints medians and their ratios, and fails below --at-least.
import { spawn } from 'node:child_process';
import { mkdtemp, readFile, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { parseArgs } from 'node:util';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    rounds: { type: 'string', default: '5' },
    size: { type: 'string', default: '512' },
    method: { type: 'string', default: 'progressive' },
    'at-least': { type: 'string', default: '0' },
  },
});
const [photond, ...scenes] = positionals;
if (scenes.length === 0) {
  console.error('usage: maps_bench.mjs PHOTOND [--rounds N] [--size N] [--method M] [--at-least RATIO] SCENE.glb...');
  process.exit(2);
}

class Service {
  static async start(data) {
    const service = new Service();
    service.process = spawn(photond, ['serve', '--port', '0', '--data', data], { stdio: ['ignore', 'pipe', 'ignore'] });
    for await (const line of createInterface({ input: service.process.stdout })) {
      const found = line.match(/http:\/\/[^ ]*/);
      if (!found) continue;
      service.url = found[0];
      return service;
    }
    throw new Error('photond did not start');
  }
  async stop() {
    const ended = once(this.process, 'exit');
    this.process.kill('SIGTERM');
    await ended;
  }
  async fetch(path, init) {
    const response = await fetch(new URL(path, this.url), init);
    if (!response.ok) throw new Error(`${path}: ${response.status} ${await response.text()}`);
    return response;
  }
  async post(path, body, type = 'application/json') {
    const text = type === 'application/json' ? JSON.stringify(body) : body;
    const response = await this.fetch(path, { method: 'POST', headers: { 'Content-Type': type }, body: text });
    return response.json();
  }
  async delete_maps() {
    const { maps } = await (await this.fetch('/v1/maps')).json();
    for (const map of maps) await this.fetch(`/v1/maps/${map.key}`, { method: 'DELETE' });
  }
  async upload(bytes) {
    const { id } = await this.post('/v1/scenes', bytes, 'model/gltf-binary');
    return (await this.fetch(`/v1/scenes/${id}`)).json();
  }
}

/** A camera like the scene's first, some steps to the side. */
function beside(scene, steps) {
  const { eye, direction, up, yfov_deg } = scene.report.cameras[0];
  const right = [0, 1, 2].map((i) => direction[(i + 1) % 3] * up[(i + 2) % 3] - direction[(i + 2) % 3] * up[(i + 1) % 3]);
  return {
    eye: eye.map((v, i) => v + 0.1 * steps * right[i]),
    target: eye.map((v, i) => v + 2 * direction[i]),
    up,
    yfov_deg,
  };
}

/** Milliseconds from the sending of a job to its first picture; returns once the job has ended. */
async function first_frame(service, scene, camera, seed) {
  const size = Number(options.size);
  const begin = performance.now();
  const job = await service.post('/v1/jobs', {
    scene: scene.id,
    camera,
    film: { width: size, height: size },
    method: options.method,
    seed,
    stop: { passes: 1 },
  });
  const picture = await service.fetch(`/v1/jobs/${job.id}/frames/latest.jpg?after=0&wait=60`);
  await picture.arrayBuffer();
  const elapsed = performance.now() - begin;
  for (;;) {
    const now = await (await service.fetch(`/v1/jobs/${job.id}`)).json();
    if (now.state === 'succeeded') return { elapsed, maps: now.maps };
    if (['failed', 'canceled'].includes(now.state)) throw new Error(JSON.stringify(now.problem));
    await new Promise((wake) => setTimeout(wake, 200));
  }
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

async function measure(bytes, seed, times) {
  const data = await mkdtemp(join(tmpdir(), 'photond-maps-'));
  let service;
  const take = async (name, scene, camera, misses) => {
    const { elapsed, maps } = await first_frame(service, scene, camera, seed);
    if ((maps.misses > 0) !== misses) throw new Error(`${name}: ${JSON.stringify(maps)}`);
    times[name].push(elapsed);
  };
  try {
    service = await Service.start(data);
    let scene = await service.upload(bytes);
    await take('cold', scene, 0, true);
    await take('warm', scene, beside(scene, 1), false);
    await service.stop();
    service = await Service.start(data);
    scene = await service.upload(bytes);
    await take('restarted_warm', scene, beside(scene, 2), false);
    await service.delete_maps();
    await service.stop();
    service = await Service.start(data);
    scene = await service.upload(bytes);
    await take('restarted_cold', scene, beside(scene, 3), true);
  } finally {
    await service?.stop();
    await rm(data, { recursive: true });
  }
}

let enough = true;
for (const file of scenes) {
  const bytes = await readFile(file);
  const times = { cold: [], warm: [], restarted_cold: [], restarted_warm: [] };
  for (let round = 0; round < Number(options.rounds); ++round) await measure(bytes, round, times);
  const ms = Object.fromEntries(Object.entries(times).map(([name, values]) => [name, median(values)]));
  const ratio = median(times.cold.map((cold, i) => cold / times.warm[i]));
  const restarted = median(times.restarted_cold.map((cold, i) => cold / times.restarted_warm[i]));
  const show = (value) => `${value.toFixed(0)} ms`;
  console.log(
    `${basename(file, '.glb')}: cold ${show(ms.cold)}, warm ${show(ms.warm)}: ${ratio.toFixed(1)} times sooner; ` +
      `after a restart cold ${show(ms.restarted_cold)}, warm ${show(ms.restarted_warm)}: ${restarted.toFixed(1)} times`,
  );
  enough = enough && Math.min(ratio, restarted) >= Number(options['at-least']);
}
if (!enough) {
  console.error(`maps_bench: less than ${options['at-least']} times sooner`);
  process.exit(1);
}
