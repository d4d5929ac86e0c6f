/** The element of the page with this id. */
export function by_id<T extends Element>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`the page has no ${type.name} #${id}`);
  return found;
}

/** A new element; `attributes` of value null are left out. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, string | null> = {}, ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/** Sets the text only where it differs, so that nothing is announced or laid out twice. */
export function set_text(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

const keys = new WeakMap<Element, string>();

/** Replaces the children only where `key` differs from that of the call before. Keyboard focus on a link stays. */
export function set_children(element: HTMLElement, key: string, children: () => Node[]): void {
  if (keys.get(element) === key) return;
  keys.set(element, key);
  const focused = element.contains(document.activeElement) ? document.activeElement?.getAttribute('href') : null;
  element.replaceChildren(...children());
  if (!focused) return;
  for (const link of element.querySelectorAll('a')) if (link.getAttribute('href') === focused) link.focus();
}
