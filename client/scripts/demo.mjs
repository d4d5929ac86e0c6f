// Renders a sample scene over HTTP and saves the picture:
//   node demo.mjs http://127.0.0.1:8080/ picture.png picture.exr
// Uses nothing but the interface that every client has, and Node 18.
import { writeFile } from 'node:fs/promises';

const job_message = {
  film: { width: 512, height: 512 },
  method: 'auto',
  stop: { seconds: 45, relative_error: 0.02 },
  label: 'demo',
};
const preferred = 'glass_and_mirror'; // caustics: what photon maps are for

class DemoError extends Error {}

/** Fetches from the service; a problem document becomes an error with its sentence. */
async function request(base, path, options) {
  const response = await fetch(new URL(path, base), options);
  if (response.ok) return response;
  const problem = await response.json().catch(() => ({}));
  throw new DemoError(`${path}: ${problem.detail ?? `status ${response.status}`}`);
}

async function choose_scene(base) {
  const { scenes } = await (await request(base, '/v1/scenes')).json();
  const samples = scenes.filter((scene) => scene.sample);
  if (samples.length === 0) throw new DemoError('the service offers no sample scene');
  return samples.find((scene) => scene.name === preferred) ?? samples[0];
}

async function submit(base, scene) {
  const response = await request(base, '/v1/jobs', {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ ...job_message, scene: scene.id }),
  });
  return response.json();
}

/** Yields { id, event, data } of one event stream until it ends. */
async function* events_of(response) {
  const decoder = new TextDecoder();
  let text = '';
  for await (const chunk of response.body) {
    text += decoder.decode(chunk, { stream: true });
    const blocks = text.split('\n\n');
    text = blocks.pop();
    for (const block of blocks) {
      const fields = {};
      for (const line of block.split('\n')) {
        const colon = line.indexOf(':');
        if (colon > 0) fields[line.slice(0, colon)] = line.slice(colon + 1).trimStart();
      }
      yield fields;
    }
  }
}

/** Follows the job through broken connections until it has ended; `show` sees every event. */
async function follow(base, job, show) {
  let last_id;
  for (let attempt = 0; attempt < 5; ++attempt) {
    const headers = last_id === undefined ? {} : { 'Last-Event-ID': last_id };
    const response = await request(base, job.urls.events, { headers });
    try {
      for await (const { id, data } of events_of(response)) {
        if (id !== undefined) last_id = id;
        if (data === undefined) continue;
        show(JSON.parse(data));
        attempt = 0;
      }
    } catch (error) {
      if (error instanceof DemoError) throw error; // others: the connection broke
    }
    const now = await (await request(base, job.urls.self)).json();
    if (['succeeded', 'failed', 'canceled'].includes(now.state)) return now;
  }
  throw new DemoError('the event stream broke five times');
}

function duration(seconds) {
  return seconds < 100 ? `${seconds.toFixed(1)} s` : `${Math.round(seconds / 60)} min`;
}

function progress_text(event) {
  const done = event.seconds / (event.seconds + (event.eta_seconds ?? Infinity)) || 0;
  const filled = Math.round(24 * done);
  const error = event.error ? `  error ${event.error.relative.toFixed(4)}` : '';
  const eta = event.eta_seconds === null ? '' : `  ETA ${duration(event.eta_seconds)}`;
  const bar = `[${'#'.repeat(filled)}${'-'.repeat(24 - filled)}] ${String(Math.floor(100 * done)).padStart(3)} %`;
  return `${bar}  ${event.state}  pass ${event.passes}  ${duration(event.seconds)}${error}${eta}`;
}

/** A function that paints events: one line that stays on a terminal, a line every two seconds elsewhere. */
function painter(out) {
  let painted = 0;
  return (event) => {
    if (out.isTTY) {
      out.write(`\r${progress_text(event).slice(0, (out.columns ?? 80) - 1)}\x1b[K`);
    } else if (Date.now() - painted >= 2000) {
      out.write(`${progress_text(event)}\n`);
      painted = Date.now();
    }
  };
}

async function save(base, job, file, format) {
  const response = await request(base, `${job.urls.latest}.${format}`);
  await writeFile(file, Buffer.from(await response.arrayBuffer()));
}

async function main(base, png, exr) {
  const scene = await choose_scene(base);
  const job = await submit(base, scene);
  console.error(`rendering the sample "${scene.name}"`);
  const ended = await follow(base, job, painter(process.stderr));
  if (process.stderr.isTTY) process.stderr.write('\r\x1b[K');
  if (ended.state !== 'succeeded') {
    throw new DemoError(`the job ended as ${ended.state}${ended.problem ? `: ${ended.problem.detail}` : ''}`);
  }
  await save(base, ended, png, 'png');
  await save(base, ended, exr, 'exr');
  const error = ended.error ? `, estimated relative error ${ended.error.relative.toFixed(4)}` : '';
  console.error(`${ended.plan.method}: ${ended.passes} passes in ${duration(ended.seconds)}${error}`);
  console.error(`saved ${png} and ${exr}`);
}

const [base, png, exr] = process.argv.slice(2);
if (exr === undefined) {
  console.error('usage: node demo.mjs URL PICTURE.png PICTURE.exr');
  process.exit(2);
}
try {
  await main(base, png, exr);
} catch (error) {
  const reason = error.cause?.message ? `${error.message}: ${error.cause.message}` : error.message;
  console.error(`demo: ${reason}`);
  process.exit(1);
}
