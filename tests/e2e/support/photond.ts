import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const at_root = (path: string) => fileURLToPath(new URL(`../../../${path}`, import.meta.url));

/** The program under test; PHOTOND_BIN names another than that of the build folder. */
export const kProgram = process.env['PHOTOND_BIN'] ?? at_root('build/server/photond');
export const kSamples = process.env['PHOTOND_SAMPLES'] ?? at_root('build/samples');
export const kClient = process.env['PHOTOND_CLIENT'] ?? at_root('client/dist');
/** Where screenshots are left. */
export const kPictures = process.env['PHOTOND_E2E_OUT'] ?? at_root('build/e2e');

/** A running service. */
export interface Photond {
  url: string;
  port: number;
  /** Ends the process and resolves once it is gone. */
  stop(): Promise<void>;
}

/**
 * Starts the service on `port` (0: any free one), with further options, and resolves once it answers. It knows nothing
 * yet, unless the options name a data directory.
 */
export async function start_photond(port = 0, options: string[] = []): Promise<Photond> {
  for (const [path, how] of [[kProgram, 'cmake'], [kSamples, 'cmake'], [`${kClient}/index.html`, 'npm run build']]) {
    if (!existsSync(path!)) throw new Error(`${path} is missing; make it with ${how}`);
  }
  const data = mkdtempSync(join(tmpdir(), 'photond-e2e-'));
  const own = options.includes('--data') ? [] : ['--data', data];
  const child = spawn(
    kProgram, ['serve', '--port', String(port), '--samples', kSamples, '--client', kClient, ...own, ...options],
    { stdio: ['ignore', 'pipe', 'pipe'] });
  const url = await announced_url(child);
  const stop = () => end(child).then(() => rmSync(data, { recursive: true, force: true }));
  return { url, port: Number(new URL(url).port), stop };
}

/** What a service tells of a job. */
export interface JobFacts {
  id: string;
  label: string;
  state: string;
}

/** Its jobs, the newest first. */
export async function jobs_of({ url }: Photond): Promise<JobFacts[]> {
  const answer = await fetch(`${url}v1/jobs?limit=200`);
  return (await answer.json() as { jobs: JobFacts[] }).jobs;
}

function announced_url(child: ChildProcess): Promise<string> {
  return new Promise((resolve, reject) => {
    let said = '';
    const listen = (text: Buffer) => {
      said += text.toString();
      const url = /serves (http:\S+)/.exec(said)?.[1];
      if (url) resolve(url);
    };
    child.stdout?.on('data', listen);
    child.stderr?.on('data', listen);
    child.once('error', reject);
    child.once('exit', (code) => reject(new Error(`photond ended with ${code} and said: ${said}`)));
  });
}

function end(child: ChildProcess): Promise<void> {
  if (child.exitCode !== null || child.signalCode !== null) return Promise.resolve();
  return new Promise((resolve) => {
    const force = setTimeout(() => child.kill('SIGKILL'), 10_000);
    child.once('exit', () => { clearTimeout(force); resolve(); });
    child.kill('SIGTERM');
  });
}
