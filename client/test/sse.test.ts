import { describe, expect, it } from 'vitest';
import { SseParser, type SseMessage } from '../src/sse';

function parse(...chunks: string[]): SseMessage[] {
  const parser = new SseParser();
  return chunks.flatMap((chunk) => parser.push(chunk));
}

const kStream = 'retry: 2000\nid: 7\n\n: heartbeat\n\nid: 8\nevent: frame\ndata: {"a":\ndata: 1}\n\ndata:x\r\n\r\n';
const kMessages = [{ event: 'frame', data: '{"a":\n1}' }, { event: 'message', data: 'x' }];

describe('SseParser', () => {
  it('reads messages wherever the text is cut', () => {
    expect(parse(kStream)).toEqual(kMessages);
    expect(parse(...kStream)).toEqual(kMessages);
    for (let cut = 0; cut < kStream.length; ++cut) {
      expect(parse(kStream.slice(0, cut), kStream.slice(cut))).toEqual(kMessages);
    }
  });

  it('remembers the id of what was completed, and the wait the server asked for', () => {
    const parser = new SseParser('3');
    expect(parser.last_id).toBe('3');
    parser.push('retry: 2000\nid: 4\ndata: a\n\nid: 5\ndata: cut o');
    expect(parser.last_id).toBe('4');
    expect(parser.retry_ms).toBe(2000);
    expect(parser.push('ff\n\n')).toEqual([{ event: 'message', data: 'cut off' }]);
    expect(parser.last_id).toBe('5');
  });

  it('ignores what it does not know', () => {
    expect(parse('colour: red\nretry: soon\ndata\n\n')).toEqual([{ event: 'message', data: '' }]);
  });
});
