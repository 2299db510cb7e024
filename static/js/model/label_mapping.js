// @ts-check
/**
 * How names in a file that match no label are imported. Pure.
 *
 * @typedef {import('../types.js').Label} Label
 * @typedef {import('../types.js').UnknownLabel} UnknownLabel
 * @typedef {{kind: 'label'|'add'|'none'|'skip', word: string}} Answer   word: the label as typed, if kind is `label`
 */
import { NO_CLASS } from './documents.js';
import { capitalized } from './format.js';
import { labelFinder } from './label_finder.js';

export const ANSWERS = /** @type {const} */ ([
  ['label', 'A label of the set'],
  ['add', 'Add as a new label'],
  ['none', 'Not in the set'],
  ['skip', 'Leave out'],
]);

/** The initial proposal: a label that resembles the name, else a new label. @param {UnknownLabel} unknown @returns {Answer} */
export const initialAnswer = ({ suggestions: [first], similar }) => ({ kind: first && similar ? 'label' : 'add', word: first?.name ?? '' });

/**
 * Map the names of a file to labels.
 *
 * @param {readonly UnknownLabel[]} unknown
 * @param {readonly Answer[]} answers      one per name
 * @param {readonly Label[]} labels
 * @returns {{map: Record<string, string|number>, add: string[], skip: string[]}|{error: string, at: number}}
 */
export function mappingOf(unknown, answers, labels) {
  /** @type {Record<string, string|number>} */
  const map = {};
  /** @type {string[]} */ const add = [];
  /** @type {string[]} */ const skip = [];
  for (const [at, { name }] of unknown.entries()) {
    const { kind, word } = answers[at];
    if (kind === 'add') add.push(name);
    else if (kind === 'skip') skip.push(name);
    else if (kind === 'none') map[name] = NO_CLASS;
    else {
      if (word.trim() === '') return { error: `Say which label “${name}” is.`, at };
      const found = findLabel(word.trim(), labels);
      if ('error' in found) return { error: capitalized(found.error), at };
      map[name] = found.key;
    }
  }
  return { map, add, skip };
}

/**
 * The label that a person means. A bare number that is part of a label's name, such as a speed limit, is ambiguous: it
 * may also be an id.
 *
 * @param {string} word
 * @param {readonly Label[]} labels
 * @returns {{key: string}|{error: string}}
 */
function findLabel(word, labels) {
  const found = labelFinder(labels).find(word);
  const quoted = `“${word.slice(0, 40)}”`;
  if (found === null) return { error: `no label is called ${quoted}.` };
  const ambiguous =
    found.how === 'number' &&
    /^\d+$/.test(word) &&
    labels.find(({ name, merged_into }) => merged_into === null && new RegExp(`(?<![\\d.,])${word}(?![.,]?\\d)`).test(name));
  if (ambiguous)
    return { error: `${quoted} can be “${ambiguous.name}”, or “${found.label.name}”, which has that number. Write the name, or #${word}.` };
  return { key: found.label.key };
}

/**
 * Parse a mapping from names of another tool to labels, one per line: `stop sign = 14`, `yield = give way`.
 *
 * @param {string} text
 * @param {readonly Label[]} labels
 * @returns {{map: Record<string, string>}|{error: string}}
 */
export function parseLabelMap(text, labels) {
  /** @type {Record<string, string>} */
  const map = {};
  for (const [at, line] of text.split('\n').entries()) {
    if (line.trim() === '') continue;
    const match = /^\s*(.+?)\s*=\s*([^=]+?)\s*$/.exec(line);
    if (!match) return { error: `Line ${at + 1}: write a name, “=”, and a label. Got “${line.trim().slice(0, 40)}”.` };
    const found = findLabel(match[2], labels);
    if ('error' in found) return { error: `Line ${at + 1}: ${found.error}` };
    map[match[1]] = found.key;
  }
  return { map };
}
