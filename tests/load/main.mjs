// The load test: node main.mjs PHOTOND SAMPLES [--only SCENARIO]… [--seconds S] [--soak S] [--quick]
// Prints a table of targets and what was measured, and fails where a target is missed.
import * as scenarios from './scenarios.mjs';
import { Figures } from './figures.mjs';
import { Server } from './server.mjs';

const names = ['slow_loris', 'viewers', 'frames', 'cancel', 'once', 'flood', 'soak'];

function parse(args) {
  const options = { only: [], seconds: 15, soak_seconds: 180, flood_count: 10_000 };
  for (let i = 0; i < args.length; ++i) {
    if (args[i] === '--only' && names.includes(args[i + 1])) options.only.push(args[++i]);
    else if (args[i] === '--seconds' && Number(args[i + 1]) > 0) options.seconds = Number(args[++i]);
    else if (args[i] === '--soak' && Number(args[i + 1]) > 0) options.soak_seconds = Number(args[++i]);
    else {
      process.stderr.write(`load: --only ${names.join('|')}, --seconds S, --soak S; not '${args[i]}'\n`);
      process.exit(2);
    }
  }
  return options;
}

const [photond, samples, ...rest] = process.argv.slice(2);
const options = parse(rest);
const figures = new Figures();
const running = [];
const start = async (flags, keys) => {
  const server = await Server.start({ photond, samples }, flags, keys);
  running.push(server);
  return server;
};
process.on('exit', () => running.forEach((server) => server.child.kill('SIGKILL')));
process.on('SIGINT', () => process.exit(130));
process.on('SIGTERM', () => process.exit(143));
// Whatever hangs, the test ends.
const limit = 60 * names.length + 10 * options.seconds + options.soak_seconds + options.flood_count / 100;
setTimeout(() => {
  process.stderr.write(`load: not done after ${limit} s\n`);
  process.exit(1);
}, limit * 1000).unref();

for (const name of options.only.length ? options.only : names) {
  process.stderr.write(`load: ${name}\n`);
  await scenarios[name]({ start, figures, ...options });
}
process.stdout.write(`${figures.markdown()}\n`);
process.exit(figures.missed.length ? 1 : 0);
