/** One message of an event stream. */
export interface SseMessage {
  event: string;
  data: string;
}

/**
 * Splits the text of an event stream into messages as the HTML standard says (§9.2.6). Text may arrive cut
 * anywhere. `last_id` is what to send as Last-Event-ID on the next connection, `retry_ms` the wait the server asked for.
 */
export class SseParser {
  last_id: string;
  retry_ms: number | null = null;
  private rest = '';
  private event = '';
  private data: string[] = [];
  private id: string;

  constructor(last_id = '') {
    this.last_id = last_id;
    this.id = last_id;
  }

  push(chunk: string): SseMessage[] {
    const lines = (this.rest + chunk).split(/\r\n|\n|\r(?!$)/);
    this.rest = lines.pop() ?? '';
    return lines.flatMap((line) => this.take(line));
  }

  private take(line: string): SseMessage[] {
    if (line === '') return this.dispatch();
    const colon = line.indexOf(':');
    const field = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (field === 'event') this.event = value;
    else if (field === 'data') this.data.push(value);
    else if (field === 'id' && !value.includes('\0')) this.id = value;
    else if (field === 'retry' && /^\d+$/.test(value)) this.retry_ms = Number(value);
    return [];
  }

  private dispatch(): SseMessage[] {
    this.last_id = this.id;
    const message = { event: this.event || 'message', data: this.data.join('\n') };
    const has_data = this.data.length > 0;
    this.event = '';
    this.data = [];
    return has_data ? [message] : [];
  }
}
