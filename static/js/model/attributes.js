// @ts-check
/**
 * Attributes of tracks: lines of the form, validation of values, filters. Pure.
 *
 * @typedef {import('../types.js').Attribute} Attribute
 * @typedef {import('../types.js').AttributeValue} AttributeValue
 * @typedef {import('../types.js').Label} Label
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 *
 * @typedef {object} AttributeRow   one line of the form
 * @property {string} name
 * @property {Attribute|null} attribute   null: the track's label has no attribute of that name; the value stays until a person removes it
 * @property {AttributeValue|null} value  in this frame; null: neither set by a person nor a default
 * @property {boolean} given              set by a person, for this frame or for the whole track
 * @property {boolean} changes            a person has set other values in some frames
 * @property {number} digit               its number among the checkboxes, from 1; 0: no checkbox
 */
import { attributesAt } from './documents.js';

/** Maximum length of a text, characters. */
const MAX_TEXT_LENGTH = 1000;

/**
 * The lines of the form: the label's attributes in order, then values left over from an earlier label.
 * @param {Label|undefined} label   of the track in the frame
 * @param {TrackDoc|null} doc       null: nobody has changed the track
 * @param {number} frame
 * @returns {AttributeRow[]}
 */
export function attributeRows(label, doc, frame) {
  const given = new Map(Object.entries(doc ? attributesAt(doc, frame) : {}));
  const changing = new Set(Object.values(doc?.keys ?? {}).flatMap((key) => Object.keys(key.attributes ?? {})));
  let digit = 0;
  const rows = (label?.attributes ?? []).map((attribute) => {
    const { name } = attribute;
    const row = {
      name,
      attribute,
      value: given.get(name) ?? attribute.default,
      given: given.has(name),
      changes: changing.has(name),
      digit: attribute.kind === 'checkbox' ? (digit += 1) : 0,
    };
    given.delete(name);
    return row;
  });
  return [
    ...rows,
    ...[...given].map(([name, value]) => ({ name, attribute: null, value, given: true, changes: changing.has(name), digit: 0 })),
  ];
}

/**
 * Why an attribute cannot have a value, in the server's words; null: it can.
 * @param {Attribute} attribute
 * @param {AttributeValue} value
 */
export function attributeProblem({ name, kind, values, low, high }, value) {
  if (kind === 'checkbox') return typeof value === 'boolean' ? null : `${name} must be true or false.`;
  if (kind === 'number') {
    if (typeof value !== 'number' || !Number.isFinite(value)) return `${name} must be a number.`;
    const isInRange = (low === null || value >= low) && (high === null || value <= high);
    return isInRange
      ? null
      : `${name} must be ${low === null ? `at most ${high}` : high === null ? `at least ${low}` : `within ${low} and ${high}`}.`;
  }
  if (typeof value !== 'string') return `${name} must be a text.`;
  if (kind === 'select') return values.includes(value) ? null : `${name} must be one of ${values.join(', ')}.`;
  return value.length <= MAX_TEXT_LENGTH ? null : `${name} must have at most ${MAX_TEXT_LENGTH} characters.`;
}

/**
 * The value in a field of the form; null: empty, which removes the value.
 * @param {Attribute} attribute
 * @param {string} text   of the field
 * @returns {AttributeValue|null}
 */
export function valueOfText({ kind }, text) {
  if (text.trim() === '') return null;
  return kind === 'number' ? Number(text) : text;
}

/** A value as text. @param {AttributeValue} value */
export const answerText = (value) => (value === true ? 'yes' : value === false ? 'no' : String(value));

/**
 * Attributes for the filter of tracks, with the values to choose from. For texts and numbers these are the values that
 * the tracks have.
 * @param {readonly Label[]} labels
 * @param {readonly TrackDoc[]} docs
 * @returns {{name: string, values: AttributeValue[]}[]}   by name
 */
export function attributeChoices(labels, docs) {
  /** @type {Map<string, Set<AttributeValue>>} */
  const found = new Map();
  /** @param {string} name @param {readonly AttributeValue[]} values */
  const add = (name, values) => {
    const choices = found.get(name) ?? new Set();
    for (const value of values) choices.add(value);
    found.set(name, choices);
  };
  for (const { attributes } of labels)
    for (const { name, kind, values } of attributes) add(name, kind === 'checkbox' ? [true, false] : values);
  for (const doc of docs) {
    for (const attributes of [doc.attributes, ...Object.values(doc.keys).map((key) => key.attributes)]) {
      for (const [name, value] of Object.entries(attributes ?? {})) add(name, [value]);
    }
  }
  return [...found].map(([name, values]) => ({ name, values: [...values] })).sort((a, b) => (a.name < b.name ? -1 : 1));
}

/**
 * Whether a track has a value in any frame. Where a person has set none, the label's default counts.
 * @param {Label|undefined} label   of the track
 * @param {TrackDoc|null|undefined} doc
 * @param {string} name
 * @param {AttributeValue|null} value   null: any value that a person has set
 */
export function hasAttribute(label, doc, name, value) {
  const given = [doc?.attributes, ...Object.values(doc?.keys ?? {}).map((key) => key.attributes)].flatMap((attributes) =>
    attributes && Object.hasOwn(attributes, name) ? [attributes[name]] : [],
  );
  if (value === null) return given.length > 0;
  if (given.includes(value)) return true;
  const hasTrackValue = doc?.attributes && Object.hasOwn(doc.attributes, name);
  return !hasTrackValue && label?.attributes.find((one) => one.name === name)?.default === value;
}
