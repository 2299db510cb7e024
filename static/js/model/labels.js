// @ts-check
/**
 * The labels of a set by id, with merged labels resolved, and their names. Pure.
 *
 * @typedef {import('../types.js').Label} Label
 */
import { NO_CLASS } from './documents.js';

/** @type {WeakMap<readonly Label[], Map<number, Label>>} */
const cache = new WeakMap();

/**
 * Every id that the set has ever used, with its label; for a merged label, the label that replaces it.
 *
 * @param {readonly Label[]} labels   must not be changed later
 * @returns {Map<number, Label>} the same map for the same list
 */
export function labelsById(labels) {
  const found = cache.get(labels);
  if (found) return found;
  const byId = new Map(labels.map((label) => [label.id, label]));
  /** @type {Map<number, Label>} */
  const currentLabels = new Map();
  for (const label of labels) {
    let current = label;
    // the server prevents cycles; a list with one must not hang the page
    for (let steps = 0; current.merged_into !== null && steps < labels.length; steps++) {
      const into = byId.get(current.merged_into);
      if (into === undefined) break;
      current = into;
    }
    currentLabels.set(label.id, current);
  }
  cache.set(labels, currentLabels);
  return currentLabels;
}

/**
 * The label of an id, with merged labels resolved.
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id
 */
export const labelFor = (labels, id) => (id === null || id === undefined ? undefined : labelsById(labels).get(id));

/**
 * The id with merged labels resolved. Null, `NO_CLASS` and unknown ids stay unchanged.
 * @template {number|null} T
 * @param {readonly Label[]} labels
 * @param {T} id
 * @returns {T|number}
 */
export const resolveLabelId = (labels, id) => labelFor(labels, id)?.id ?? id;

/**
 * A command with the key of its label, because the video may use another label set when the server receives it.
 * @param {import('../types.js').Command} command
 * @param {readonly Label[]} labels
 * @returns {import('../types.js').Command}
 */
export function withLabelKey(command, labels) {
  if (command.label_key !== undefined || command.name === 'split' || command.name === 'merge') return command;
  const label = labels.find(({ id }) => id === command.class_id);
  return label ? { ...command, label_key: label.key } : command;
}

/** Labels that can be assigned: neither hidden nor merged. @param {readonly Label[]} labels */
export const offeredLabels = (labels) => labels.filter(({ hidden, merged_into }) => !hidden && merged_into === null);

/**
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id   `NO_CLASS`: given by a person; null: given neither by a person nor by the engine
 */
export function labelName(labels, id) {
  if (id === NO_CLASS) return 'not in the set';
  return labelFor(labels, id)?.name ?? (id === null || id === undefined ? 'unlabelled' : `label ${id}`);
}

/**
 * The same for the engine's class, which may be a sign without a label in the set.
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id
 * @param {string|null|undefined} word   the engine's name for it, if the set has no label for it
 */
export const engineName = (labels, id, word) => (word && id === NO_CLASS ? `${word} (not in the set)` : labelName(labels, id));
