import {
  by_tag, kind_words, ref_name, resolved, scope_of,
  type Answer, type Contract, type Media, type NamedOperation, type Parameter, type Schema,
} from './contract';
import { by_id, make } from './dom';

const contract = await (await fetch('v1/openapi.json')).json() as Contract;

function show(): void {
  const groups = by_tag(contract);
  by_id('contents', HTMLElement).replaceChildren(...[...groups].map(([tag, operations]) => contents_of(tag, operations)),
    make('h2', {}, make('a', { href: '#schemas' }, 'Schemas')));
  const { title, version, description } = contract.info;
  by_id('interface', HTMLElement).replaceChildren(
    make('section', { class: 'panel intro' }, make('h2', {}, `${title} ${version}`), make('p', {}, description),
      make('h3', {}, 'Keys'), make('p', {}, contract.components.securitySchemes['key']?.description ?? '')),
    ...[...groups].flatMap(([tag, operations]) => [make('h2', { class: 'group', id: id_of(tag) }, tag),
      ...operations.map(operation_card)]),
    make('h2', { class: 'group', id: 'schemas' }, 'Schemas'),
    ...Object.entries(contract.components.schemas).map(([name, schema]) => schema_card(name, schema)),
  );
  if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
}

function id_of(tag: string): string {
  return tag.toLowerCase().replace(/\W+/g, '-');
}

function contents_of(tag: string, operations: NamedOperation[]): HTMLElement {
  return make('section', {}, make('h2', {}, make('a', { href: `#${id_of(tag)}` }, tag)),
    make('ul', {}, ...operations.map(({ method, path, operation }) =>
      make('li', {}, make('a', { href: `#${operation.operationId}` }, method_badge(method), path_text(path))))));
}

function method_badge(method: string): HTMLElement {
  return make('span', { class: 'method', 'data-method': method }, method);
}

/** The path, which may break after each slash. */
function path_text(path: string): HTMLElement {
  return make('code', { class: 'path' }, ...path.split(/(?<=\/)/).flatMap((part, index) => (index ? [make('wbr'), part] : [part])));
}

function operation_card({ method, path, operation }: NamedOperation): HTMLElement {
  const scope = scope_of(contract, operation);
  const card = make('section', { class: 'panel operation', id: operation.operationId },
    make('h3', {}, method_badge(method), path_text(path),
      make('span', { class: 'scope' }, scope === null ? 'no key needed' : `key: ${scope}`)),
    make('p', {}, operation.summary));
  if (operation.description) card.append(make('p', { class: 'soft' }, operation.description));
  if (operation.parameters?.length) {
    card.append(make('h4', {}, 'Parameters'), table(operation.parameters.map((one) => parameter_row(resolved(contract, one)))));
  }
  const body = operation.requestBody;
  if (body) {
    card.append(make('h4', {}, 'Body'), ...(body.description ? [make('p', { class: 'soft' }, body.description)] : []),
      ...Object.entries(body.content).flatMap(([type, media]) => media_parts(type, media)));
  }
  const answers = Object.entries(operation.responses);
  const refusals = answers.map(([status]) => status).filter(is_refusal);
  card.append(make('h4', {}, 'Answers'), table([
    ...answers.filter(([status]) => !is_refusal(status)).map(([status, answer]) => answer_row(status, resolved(contract, answer))),
    row(refusals.flatMap((status) => [make('code', {}, status === 'default' ? 'other' : status), ' ']),
      make('p', {}, 'Refused: a ', make('a', { href: '#schema-Problem' }, 'Problem'), ' says why and where')),
  ]));
  for (const answer of Object.values(operation.responses)) card.append(...answer_examples(resolved(contract, answer)));
  return card;
}

function table(rows: Node[]): HTMLElement {
  return make('dl', { class: 'fields' }, ...rows);
}

function row(name: (Node | string)[], ...rest: (Node | string)[]): HTMLElement {
  return make('div', {}, make('dt', {}, ...name), make('dd', {}, ...rest));
}

function parameter_row({ name, in: place, required, description, schema }: Parameter): HTMLElement {
  return row([make('code', {}, name), ' ', make('small', {}, place + (required ? ', required' : ''))],
    make('p', {}, description), kind(schema));
}

function is_refusal(status: string): boolean {
  return status === 'default' || status >= '400';
}

function answer_row(status: string, answer: Answer): HTMLElement {
  const content = Object.entries(answer.content ?? {}).map(([type, { schema }]) =>
    make('div', { class: 'kind' }, make('code', {}, type), ...(ref_name(schema) ? [' ', ...kind_nodes(schema)] : []),
      ...(schema.properties ? [fields_of(schema)] : [])));
  const headers = Object.entries(answer.headers ?? {}).map(([name, header]) =>
    make('p', { class: 'kind' }, make('code', {}, name), ` ${resolved(contract, header).description}`));
  return row([make('code', {}, status)], make('p', {}, answer.description), ...content, ...headers);
}

function media_parts(type: string, media: Media): Node[] {
  const fields = ref_name(media.schema) ? [make('p', { class: 'kind' }, make('code', {}, type), ' ', ...kind_nodes(media.schema))]
    : [make('p', { class: 'kind' }, make('code', {}, type))];
  return [...fields, ...examples_of(media)];
}

function answer_examples(answer: Answer): Node[] {
  return Object.values(answer.content ?? {}).flatMap(examples_of);
}

function examples_of(media: Media): Node[] {
  return Object.values(media.examples ?? {}).map(({ summary, value }) => example(summary, value));
}

function example(summary: string, value: unknown): HTMLElement {
  return make('details', {}, make('summary', {}, `Example: ${summary}`), make('pre', {}, json_text(value)));
}

/** JSON with short arrays and objects on one line. */
function json_text(value: unknown, indent = ''): string {
  const short = JSON.stringify(value, null, 1).replace(/\n\s*/g, ' ');
  if (short.length + indent.length <= 72 || typeof value !== 'object' || value === null) return short;
  const deeper = `${indent}  `;
  if (Array.isArray(value)) return `[\n${value.map((item) => deeper + json_text(item, deeper)).join(',\n')}\n${indent}]`;
  const members = Object.entries(value).map(([name, member]) => `${deeper}${JSON.stringify(name)}: ${json_text(member, deeper)}`);
  return `{\n${members.join(',\n')}\n${indent}}`;
}

function kind_nodes(schema: Schema): Node[] {
  return kind_words(schema).map(({ text, name }) =>
    (name === null ? document.createTextNode(text) : make('a', { href: `#schema-${name}` }, text)));
}

function kind(schema: Schema): HTMLElement {
  const missing = schema.default === undefined ? [] : [make('span', {}, '; default ', make('code', {}, JSON.stringify(schema.default)))];
  return make('p', { class: 'kind' }, ...kind_nodes(schema), ...missing);
}

function schema_card(name: string, schema: Schema): HTMLElement {
  const card = make('section', { class: 'panel schema', id: `schema-${name}` }, make('h3', {}, name));
  if (schema.description) card.append(make('p', {}, schema.description));
  card.append(...(schema.properties ? [fields_of(schema)] : [kind(schema)]));
  for (const value of schema.examples ?? []) card.append(example(name, value));
  return card;
}

/** The members of an object, those of objects inside indented below. */
function fields_of(schema: Schema): HTMLElement {
  return table(Object.entries(schema.properties ?? {}).map(([name, member]) => {
    const needed = schema.required?.includes(name) ? [' ', make('small', {}, 'required')] : [];
    const inner = member.properties ? member : member.items?.properties ? member.items : null;
    return row([make('code', {}, name), ...needed], ...(member.description ? [make('p', {}, member.description)] : []),
      kind(member), ...(inner ? [fields_of(inner)] : []));
  }));
}

show();
