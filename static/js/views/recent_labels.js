// @ts-check
/**
 * The labels assigned last in this browser, because signs come in series. Stored by key, because ids belong to one set.
 */

import { recall, remember } from '../core/preferences.js';

/** @typedef {import('../types.js').Label} Label */

/** Number of labels that are stored. */
const MAX_STORED = 8;

/** @returns {string[]} */
function readStored() {
  try {
    const stored = JSON.parse(recall('labels.recent') ?? '[]');
    return Array.isArray(stored) ? stored.filter((key) => typeof key === 'string') : [];
  } catch {
    return [];
  }
}

/** @param {Label} label   the label assigned just now */
export const addRecentLabel = ({ key }) =>
  remember('labels.recent', JSON.stringify([key, ...readStored().filter((other) => other !== key)].slice(0, MAX_STORED)));

/** @param {readonly Label[]} labels @param {string|null} key @returns {number|null} */
export const labelIdOfKey = (labels, key) => labels.find((label) => label.key === key)?.id ?? null;

/** Ids of the labels assigned last, latest first. @param {readonly Label[]} labels */
export const recentLabelIds = (labels) => readStored().flatMap((key) => labelIdOfKey(labels, key) ?? []);
