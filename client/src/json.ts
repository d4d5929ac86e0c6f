// JSON as photond writes it. A seed may be larger than what a number holds exactly, so here it is a text of digits.

export function read_json(text: string): unknown {
  return JSON.parse(text.replace(/"seed":\s*(\d+)/g, '"seed":"$1"'));
}

export function write_json(value: unknown): string {
  return JSON.stringify(value).replace(/"seed":"(\d+)"/g, '"seed":$1');
}
