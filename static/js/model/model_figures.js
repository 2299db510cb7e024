// @ts-check
/**
 * Figures of a model version beside those of the version that it was made from. Pure.
 *
 * @typedef {'better'|'worse'|'same'|'new'} Verdict   `new`: the earlier version has no such figure
 * @typedef {{name: string, label: string, now: number, before: number|null, share: boolean, verdict: Verdict|null}} FigureRow
 *   verdict null: neither better nor worse, or there is nothing to compare with
 * @typedef {{name: string, title: string, note: string, of: string, rows: FigureRow[]}} FigureGroup
 */

import { capitalized, plural } from './format.js';

/** Names of figures; 1: higher is better, -1: lower is better, 0: neither; whether the figure is a share of 1. */
const FIGURES = /** @type {Record<string, [string, 1|-1|0, boolean]>} */ ({
  ap50: ['Average precision, IoU 0.5', 1, true],
  ap75: ['Average precision, IoU 0.75', 1, true],
  'recall_at_0.03': ['Recall at 0.03 false detections a picture', 1, true],
  'recall_at_0.1': ['Recall at 0.1 false detections a picture', 1, true],
  'recall_at_0.2': ['Recall at 0.2 false detections a picture', 1, true],
  recall_at_1: ['Recall at 1 false detection a picture', 1, true],
  mean_eq7: ['Localisation error (Eq. 7)', -1, false],
  accuracy: ['Crops classified correctly', 1, true],
  accuracy_shaken_boxes: ['Crops classified correctly, displaced boxes', 1, true],
  negative_log_likelihood: ['Negative log-likelihood', -1, false],
  crops_right: ['Crops classified correctly', 1, true],
  signs_right: ['Signs classified correctly', 1, true],
  signs_kept: ['Signs still detected', 1, true],
  others_kept: ['Background still refused', 1, true],
  crops_kept: ['Crops still classified correctly', 1, true],
});

/** Fields that hold the amounts of data behind the figures. */
const COUNTS = ['pictures', 'signs', 'crops'];

const GROUPS = /** @type {Record<string, [string, string]>} */ ({
  corrections: [
    'Held-out corrections',
    'Of a trial version that has not learned from these signs; the version itself has learned from all.',
  ],
  remembered: ['Remembered training data', 'What the version still gets right of the data that the shipped one was made from.'],
  gtsdb: ['GTSDB scenes', 'Scenes that training reports on.'],
  gtsrb: ['GTSRB tracks', 'Tracks that training held out.'],
  detector: ['Detector', 'On scenes that it was not trained on.'],
  classifier: ['Classifier', 'On tracks that it was not trained on.'],
  network_classifier: ['Network with the classifier', 'On tracks that it was not trained on.'],
  prior: ['Spatial prior', 'Detection with the prior, on scenes that it was not trained on.'],
  online: ['Online detector', ''],
  other_shapes: ['Signs outside the classes', 'On scenes that a model of the other scenes judges.'],
});

/** Changes up to this count as no change. */
const NO_CHANGE = 0.0005;

/**
 * @param {Record<string, any>} figures   of a version
 * @returns {FigureGroup[]} the groups that hold numbers
 */
export function figureGroups(figures) {
  const groups = [];
  for (const [name, value] of Object.entries(figures)) {
    if (!isRecord(value)) continue;
    const compared = isRecord(value.new);
    const rows = rowsOf(compared ? value.new : value, compared && isRecord(value.parent) ? value.parent : null);
    const [title, note] = GROUPS[name] ?? [readableName(name), ''];
    if (rows.length) groups.push({ name, title, note, of: countsOf(compared ? value.new : value), rows });
  }
  return groups;
}

/** The regressions, in the server's sentences. @param {Record<string, any>} figures @returns {string[]} */
export const regressions = (figures) => (Array.isArray(figures.worse) ? figures.worse.map(String) : []);

/**
 * @param {Record<string, any>} now
 * @param {Record<string, any>|null} before
 * @param {string} [prefix]
 * @returns {FigureRow[]}
 */
function rowsOf(now, before, prefix = '') {
  const rows = [];
  for (const [name, value] of Object.entries(now)) {
    if (isRecord(value)) {
      rows.push(...rowsOf(value, isRecord(before?.[name]) ? before[name] : null, `${readableName(name)}: `));
      continue;
    }
    if (typeof value !== 'number' || !Number.isFinite(value) || COUNTS.includes(name)) continue;
    const [label, direction, share] = FIGURES[name] ?? [readableName(name), 0, false];
    const old = typeof before?.[name] === 'number' ? before[name] : null;
    rows.push({
      name: prefix + name,
      label: prefix + label,
      now: value,
      before: old,
      share,
      verdict: before === null ? null : verdictOf(value, old, direction),
    });
  }
  return rows;
}

/** @param {number} now @param {number|null} before @param {1|-1|0} direction @returns {Verdict|null} */
function verdictOf(now, before, direction) {
  if (direction === 0) return null;
  if (before === null) return 'new';
  const gain = (now - before) * direction;
  return Math.abs(gain) <= NO_CHANGE ? 'same' : gain > 0 ? 'better' : 'worse';
}

/** The amounts of data behind the figures: `150 pictures, 220 signs`. @param {Record<string, any>} now @returns {string} */
function countsOf(now) {
  const parts = COUNTS.filter((name) => typeof now[name] === 'number').map((name) => plural(now[name], name.slice(0, -1)));
  if (parts.length) return `${parts.join(', ')}.`;
  const [inner] = Object.values(now).filter(isRecord);
  return inner ? countsOf(inner) : '';
}

/** @param {string} name */
const readableName = (name) => capitalized(name).replaceAll('_', ' ');

/** @param {unknown} value @returns {value is Record<string, any>} */
const isRecord = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
