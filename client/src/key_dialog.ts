import { describe, fetch_file } from './api';
import { by_id } from './dom';
import { has_key, use_key } from './key';

const kStored = 'photond-key'; // in sessionStorage: gone with the tab

/** Takes the key of this tab into use, and asks for one when the server wants it. */
export function set_up_key(): void {
  const dialog = by_id('key-dialog', HTMLDialogElement);
  const input = by_id('key', HTMLInputElement);
  use_key(sessionStorage.getItem(kStored) ?? '', () => {
    by_id('key-unknown', HTMLElement).hidden = !has_key();
    if (!dialog.open) dialog.showModal();
  });
  by_id('key-form', HTMLFormElement).addEventListener('submit', (event) => {
    event.preventDefault();
    sessionStorage.setItem(kStored, input.value.trim());
    location.reload(); // everything is asked for again
  });
}

/** Takes a sentence about what went wrong; null: what it was about is tried again. */
export type Notice = (words: string | null) => void;

/** Links carry no key: where there is one, the file is fetched with it and saved from memory. */
export function save_with_key(event: MouseEvent, on_notice: Notice): void {
  const link = event.currentTarget;
  if (!has_key() || !(link instanceof HTMLAnchorElement)) return;
  event.preventDefault();
  void save(link.href, link.download, on_notice);
}

async function save(url: string, name: string, on_notice: Notice): Promise<void> {
  on_notice(null);
  const file = await fetch_file(url);
  if (!file.ok) return on_notice(`${name}: ${describe(file.failure)}`);
  const saved = document.createElement('a');
  saved.href = URL.createObjectURL(file.value);
  saved.download = name;
  saved.click();
  setTimeout(() => URL.revokeObjectURL(saved.href), 60_000); // by then the browser has read it
}
