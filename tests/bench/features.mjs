// What features cost a scene that has none of them: node features.mjs WITH WITHOUT [--rounds N] [--at-least RATIO]
// Runs both programs in turns, either first, and prints medians and the median of the rounds' ratios. Fails where that is
// below --at-least.
import { execFileSync } from 'node:child_process';
import { parseArgs } from 'node:util';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { rounds: { type: 'string', default: '15' }, 'at-least': { type: 'string', default: '0' } },
});
const programs = positionals.slice(0, 2);
const times = programs.map(() => new Map());

function median(values) {
  return [...values].sort((a, b) => a - b)[values.length >> 1];
}

for (let round = 0; round < Number(options.rounds); ++round) {
  for (const i of round % 2 === 0 ? [0, 1] : [1, 0]) {
    for (const line of execFileSync(programs[i], { encoding: 'utf8' }).trim().split('\n')) {
      const [name, seconds] = line.split(' ');
      times[i].set(name, [...(times[i].get(name) ?? []), Number(seconds)]);
    }
  }
}

let enough = true;
console.log('work          with features  compiled out  rate with / without');
for (const [name, all_seconds] of times[0]) {
  const none_seconds = times[1].get(name);
  const [all, none] = [median(all_seconds), median(none_seconds)];
  const ratio = median(all_seconds.map((seconds, round) => none_seconds[round] / seconds));
  enough &&= ratio >= Number(options['at-least']);
  console.log(`${name.padEnd(13)} ${`${(1e3 * all).toFixed(1)} ms`.padStart(13)} ${`${(1e3 * none).toFixed(1)} ms`.padStart(13)}  ${ratio.toFixed(3)}`);
}
process.exit(enough ? 0 : 1);
