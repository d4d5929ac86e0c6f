// A thread of its own asks /healthz one time after the other: what the crowd costs its own thread is not measured.
import { parentPort, workerData } from 'node:worker_threads';
import { call } from './client.mjs';
import { sleep } from './figures.mjs';

const { port, seconds } = workerData;
const times = [];
const end = performance.now() + seconds * 1000;
while (performance.now() < end) {
  const reply = await call(port, 'GET', '/healthz');
  if (reply.status !== 200) throw new Error(`/healthz answered ${reply.status}`);
  times.push(reply.ms);
  await sleep(20);
}
parentPort.postMessage(times);
