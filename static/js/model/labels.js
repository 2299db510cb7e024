// @ts-check
/**
 * The labels of a set by id: which label stands for an id since labels were merged, and what it is called. Pure.
 *
 * @typedef {import('../types.js').Label} Label
 */
import { NO_CLASS } from './documents.js';

/** @type {WeakMap<readonly Label[], Map<number, Label>>} */
const known = new WeakMap();

/**
 * Every id that the set has given out, with the label that stands for it.
 *
 * @param {readonly Label[]} labels   not changed after this
 * @returns {Map<number, Label>} the same map for the same list
 */
export function labelsById(labels) {
  const found = known.get(labels);
  if (found) return found;
  const own = new Map(labels.map((label) => [label.id, label]));
  /** @type {Map<number, Label>} */
  const standing = new Map();
  for (const label of labels) {
    let at = label;
    // the server keeps circles out; a list that has one all the same must not hang the page
    for (let steps = 0; at.merged_into !== null && steps < labels.length; steps++) {
      const into = own.get(at.merged_into);
      if (into === undefined) break;
      at = into;
    }
    standing.set(label.id, at);
  }
  known.set(labels, standing);
  return standing;
}

/**
 * The label that stands for an id.
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id
 */
export const labelFor = (labels, id) => (id === null || id === undefined ? undefined : labelsById(labels).get(id));

/**
 * The id that stands for an id; null, `NO_CLASS` and ids that the set has never given out stand for themselves.
 * @template {number|null} T
 * @param {readonly Label[]} labels
 * @param {T} id
 * @returns {T|number}
 */
export const resolved = (labels, id) => labelFor(labels, id)?.id ?? id;

/**
 * A command that says by key which label it means: the video may use another label set when the server gets it.
 * @param {import('../types.js').Command} command
 * @param {readonly Label[]} labels
 * @returns {import('../types.js').Command}
 */
export function withLabelKey(command, labels) {
  if (command.label_key !== undefined || command.name === 'split') return command;
  const label = labels.find(({ id }) => id === command.class_id);
  return label ? { ...command, label_key: label.key } : command;
}

/** Labels that can be given: neither hidden nor merged. @param {readonly Label[]} labels */
export const offeredLabels = (labels) => labels.filter(({ hidden, merged_into }) => !hidden && merged_into === null);

/**
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id   `NO_CLASS`: a person says so; null: nobody has said, and the engine has read none
 */
export function className(labels, id) {
  if (id === NO_CLASS) return 'not in the set';
  return labelFor(labels, id)?.name ?? (id === null || id === undefined ? 'unlabelled' : `label ${id}`);
}

/**
 * The same for what the engine reads, which may be a sign that the set has no label for.
 * @param {readonly Label[]} labels
 * @param {number|null|undefined} id
 * @param {string|null|undefined} word   what the engine calls it, where the set lacks that
 */
export const engineName = (labels, id, word) => (word && id === NO_CLASS ? `${word} (not in the set)` : className(labels, id));
