// @ts-check
/**
 * The input of the form of a label, and the change of the set that it makes. Pure.
 *
 * @typedef {import('../types.js').Attribute} Attribute
 * @typedef {import('../types.js').Label} Label
 * @typedef {import('../types.js').LabelChange} LabelChange
 * @typedef {{name: string, kind: Attribute['kind'], mutable: boolean, values: string, low: string, high: string, start: string}} AttributeForm   as typed; values: one per line; start: the default
 * @typedef {{key: string, name: string, short: string, aliases: string, shape: string, category: string, teach: Label['teach'], colour: string, pinned: string, size_mm: string, mirror: string, attributes: AttributeForm[]}} LabelForm
 */

export const SHAPES = /** @type {const} */ (['triangle', 'inverted triangle', 'circle', 'octagon', 'diamond', 'rectangle', 'other']);
export const CATEGORIES = /** @type {const} */ ([
  'prohibitory',
  'mandatory',
  'danger',
  'priority',
  'information',
  'direction',
  'additional',
  'other',
]);
export const KINDS = /** @type {const} */ ([
  ['checkbox', 'yes or no'],
  ['select', 'one of several'],
  ['number', 'number'],
  ['text', 'text'],
]);

/** @type {AttributeForm} */
export const NEW_ATTRIBUTE = Object.freeze({ name: '', kind: 'checkbox', mutable: false, values: '', low: '', high: '', start: '' });

/** The form of a label, or of a new one. @param {Label|null} label @returns {LabelForm} */
export function formOf(label) {
  const text = (/** @type {unknown} */ value) => (value === null || value === undefined ? '' : String(value));
  return {
    key: label?.key ?? '',
    name: label?.name ?? '',
    short: label?.short ?? '',
    aliases: (label?.aliases ?? []).join('\n'),
    shape: label?.shape ?? 'other',
    category: label?.category ?? 'other',
    teach: label?.teach ?? 'sign',
    colour: text(label?.colour),
    pinned: text(label?.pinned),
    size_mm: text(label?.size_mm),
    mirror: text(label?.mirror),
    attributes: (label?.attributes ?? []).map((one) => ({
      name: one.name,
      kind: one.kind,
      mutable: one.mutable,
      values: one.values.join('\n'),
      low: text(one.low),
      high: text(one.high),
      start: text(one.default),
    })),
  };
}

/** Lines that are not empty, without duplicates. @param {string} text */
const lines = (text) => [
  ...new Set(
    text
      .split('\n')
      .map((line) => line.trim())
      .filter(Boolean),
  ),
];

/** @param {string} text @param {string} what @returns {number|null} @throws {Error} a sentence */
function numberOf(text, what) {
  const typed = text.trim();
  if (typed === '') return null;
  const value = /^[+-]?(\d+\.?\d*|\.\d+)$/.test(typed) ? Number(typed) : Number.NaN;
  if (!Number.isFinite(value)) throw new Error(`${what} must be a number, not “${typed.slice(0, 40)}”.`);
  return value;
}

/** @param {AttributeForm} form @returns {Attribute} @throws {Error} a sentence */
function attributeOf({ name, kind, mutable, values, low, high, start }) {
  const title = name.trim();
  if (title === '') throw new Error('Give every attribute a name.');
  const quotedName = `“${title}”`;
  const choices = kind === 'select' ? lines(values) : [];
  if (kind === 'select' && choices.length === 0) throw new Error(`${quotedName}: write its values, one per line.`);
  const typed = start.trim();
  /** @type {Attribute['default']} */
  let value = typed === '' ? null : typed;
  if (value !== null && kind === 'checkbox') value = typed === 'true';
  if (value !== null && kind === 'number') value = numberOf(typed, `${quotedName}: the default`);
  if (kind === 'select' && value !== null && !choices.includes(typed))
    throw new Error(`${quotedName}: the default must be one of its values.`);
  const number = kind === 'number';
  return {
    name: title,
    kind,
    mutable,
    values: choices,
    low: number ? numberOf(low, `${quotedName}: the smallest value`) : null,
    high: number ? numberOf(high, `${quotedName}: the largest value`) : null,
    default: value,
  };
}

/**
 * The fields of a label with the input of the form.
 * @param {LabelForm} form
 * @returns {Record<string, unknown>}
 * @throws {Error} a sentence
 */
function fieldsOf(form) {
  const name = form.name.trim();
  if (name === '') throw new Error('Give it a name.');
  return {
    name,
    short: form.short.trim(),
    aliases: lines(form.aliases),
    shape: form.shape,
    category: form.category,
    teach: form.teach,
    colour: form.colour.trim().toLowerCase() || null,
    attributes: form.attributes.map(attributeOf),
    pinned: form.pinned === '' ? null : Number(form.pinned),
    size_mm: numberOf(form.size_mm, 'The width'),
    mirror: form.mirror.trim() || null,
  };
}

/** The fields of a stored label. A label of another tool can have values that the form refuses: then all are sent. @param {Label} label */
function storedFields(label) {
  try {
    return fieldsOf(formOf(label));
  } catch {
    return {};
  }
}

/**
 * @param {Label|null} label   the present label; null: a new one
 * @param {LabelForm} form
 * @returns {{change: LabelChange|null}|{error: string}}   null: nothing has changed
 */
export function changeOf(label, form) {
  try {
    const fields = fieldsOf(form);
    if (label === null) {
      const key = form.key.trim();
      return { change: { type: 'add', ...fields, ...(key ? { key } : {}) } };
    }
    const before = storedFields(label);
    const changed = Object.entries(fields).filter(([field, value]) => JSON.stringify(value) !== JSON.stringify(before[field]));
    return { change: changed.length ? { type: 'update', id: label.id, ...Object.fromEntries(changed) } : null };
  } catch (thrown) {
    return { error: thrown instanceof Error ? thrown.message : String(thrown) };
  }
}
