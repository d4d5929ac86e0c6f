// A photond of the load test's own: a free port on loopback, a temporary data directory, ended by its pid.
import { execFileSync, spawn } from 'node:child_process';
import { mkdtemp, readFile, readdir, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const clock_ticks = 100; // per second, in /proc/PID/stat; Linux has no other on x86-64

export class Server {
  /** With `keys`, a list of arguments to `photond key create`, the server asks for keys; they are in `server.keys`. */
  static async start({ photond, samples }, options = [], keys = []) {
    const data = await mkdtemp(join(tmpdir(), 'photond-load-'));
    const made = keys.map((more) => execFileSync(photond, ['key', 'create', '--data', data, ...more], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }).trim());
    const child = spawn(
      photond,
      ['serve', '--port', '0', '--data', data, '--samples', samples, '--log-level', 'warning', ...options],
      { stdio: ['ignore', 'pipe', 'inherit'] },
    );
    const server = new Server(child, data);
    server.keys = made;
    server.port = await server.#announced_port();
    return server;
  }

  constructor(child, data) {
    this.child = child;
    this.data = data;
    this.ended = new Promise((resolve) => child.once('exit', (code, signal) => resolve({ code, signal })));
  }

  async #announced_port() {
    let text = '';
    for await (const chunk of this.child.stdout) {
      text += chunk;
      const port = /http:\/\/[^:]+:(\d+)\//.exec(text)?.[1];
      if (port) return Number(port);
    }
    throw new Error('photond did not start');
  }

  /** Ends it by SIGTERM; throws where it does not end by itself and cleanly. */
  async stop() {
    this.child.kill('SIGTERM');
    const timer = setTimeout(() => this.child.kill('SIGKILL'), 30_000);
    const { code, signal } = await this.ended;
    clearTimeout(timer);
    await rm(this.data, { recursive: true, force: true });
    if (code !== 0) throw new Error(`photond ended by ${signal ?? `code ${code}`}`);
  }

  /** Seconds of processor time used so far. */
  async cpu_seconds() {
    const stat = await readFile(`/proc/${this.child.pid}/stat`, 'utf8');
    const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
    return (Number(fields[11]) + Number(fields[12])) / clock_ticks;
  }

  async resident_bytes() {
    const status = await readFile(`/proc/${this.child.pid}/status`, 'utf8');
    return Number(/VmRSS:\s+(\d+)/.exec(status)[1]) * 1024;
  }

  async descriptors() {
    return (await readdir(`/proc/${this.child.pid}/fd`)).length;
  }
}
