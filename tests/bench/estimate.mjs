// Compares what a dry run says of a job with what the job then takes, for every sample and method:
//   node estimate.mjs PHOTOND SAMPLES [--size N] [--passes N]
// Each in a process of its own, whose largest memory is then the job's. Fails where one is off by more than a factor of 2.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const methods = ['path', 'progressive', 'photon_map', 'hybrid'];
const [program, samples, ...rest] = process.argv.slice(2);
const option = (name, missing) => (rest.includes(name) ? Number(rest[rest.indexOf(name) + 1]) : missing);
const size = option('--size', 384);
const passes = option('--passes', 24);

/** A service of its own while `use` runs. */
async function with_service(use) {
  const data = mkdtempSync(join(tmpdir(), 'photond-estimate-'));
  const child = spawn(program, ['serve', '--port', '0', '--samples', samples, '--data', data, '--log-level', 'warning'],
    { stdio: ['ignore', 'pipe', 'inherit'] });
  try {
    const url = await new Promise((resolve, reject) => {
      let said = '';
      child.stdout.on('data', (text) => {
        said += text;
        const found = /serves (http:\S+)/.exec(said);
        if (found) resolve(found[1]);
      });
      child.once('exit', (code) => reject(new Error(`photond ended with ${code}`)));
    });
    return await use(url, child.pid);
  } finally {
    const gone = new Promise((resolve) => child.once('exit', resolve));
    child.kill('SIGTERM');
    await gone;
    rmSync(data, { recursive: true });
  }
}

async function ask(url, init) {
  const response = await fetch(url, init);
  const body = await response.json();
  if (!response.ok) throw new Error(`${url}: ${body.detail}`);
  return body;
}

const post = (url, body) =>
  ask(url, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) });

function memory(pid, field) {
  return 1024 * Number(new RegExp(`${field}:\\s*(\\d+) kB`).exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]);
}

async function job_of(url, name, method) {
  const { scenes } = await ask(`${url}v1/scenes`);
  return { scene: scenes.find((scene) => scene.name === name).id, method, film: { width: size, height: size }, stop: { passes } };
}

const estimate = (name, method) => with_service(async (url) =>
  (await post(`${url}v1/jobs?dry_run=true`, await job_of(url, name, method))).estimate);

const truth = (name, method) => with_service(async (url, pid) => {
  const spec = await job_of(url, name, method);
  const idle = memory(pid, 'VmRSS');
  let job = await post(`${url}v1/jobs`, spec);
  while (!['succeeded', 'failed', 'canceled'].includes(job.state)) {
    await new Promise((resolve) => setTimeout(resolve, 100));
    job = await ask(`${url}v1/jobs/${job.id}`);
  }
  return { seconds: job.seconds, memory_bytes: memory(pid, 'VmHWM') - idle };
});

let worst = 1;
const off = (told, true_value) => {
  worst = Math.max(worst, told / true_value, true_value / told);
  return (told / true_value).toFixed(2);
};
console.log(`${size}×${size}, ${passes} passes; ratio = estimate / truth`);
console.log('sample            method       seconds  ratio   memory MB  ratio');
for (const file of readdirSync(samples).filter((entry) => entry.endsWith('.glb')).sort()) {
  for (const method of methods) {
    const name = file.replace('.glb', '');
    const told = await estimate(name, method);
    const found = await truth(name, method);
    console.log([name.padEnd(17), method.padEnd(12), found.seconds.toFixed(2).padStart(7),
      off(told.seconds, found.seconds).padStart(6), (found.memory_bytes / 2 ** 20).toFixed(0).padStart(11),
      off(told.memory_bytes, found.memory_bytes).padStart(6)].join(' '));
  }
}
console.log(`worst factor: ${worst.toFixed(2)}`);
process.exit(worst <= 2 ? 0 : 1);
