// @ts-check
/** Texts about files made from runs. Pure functions. */

import { listNames } from '../model/track_name.js';
import { bytes, count, moment, plural } from '../model/format.js';

/** @typedef {import('../types.js').Output} Output */

/** @type {Record<Output['kind'], {name: string, pluralName: string, icon: import('./icons.js').IconName}>} */
export const KINDS = {
  export: { name: 'Export', pluralName: 'Exports', icon: 'export' },
  recording: { name: 'Recording', pluralName: 'Recordings', icon: 'film' },
  bundle: { name: 'Bug bundle', pluralName: 'Bug bundles', icon: 'bug' },
  scene: { name: '3-D page', pluralName: '3-D pages', icon: 'cube' },
};

/** @type {Record<Output['state'], [string, string]>} word and class of the badge */
const STATES = {
  queued: ['waiting', ''],
  running: ['in progress', 'badge-accent'],
  complete: ['ready', 'badge-good'],
  failed: ['failed', 'badge-bad'],
  cancelled: ['cancelled', 'badge-warn'],
};

/** @param {{state: Output['state']}} made @returns {[string, string]} */
export const stateBadge = ({ state }) => STATES[state] ?? [state, ''];

/** @param {{state: string}} made */
export const isActive = ({ state }) => state === 'queued' || state === 'running';

/** @param {{done: number, total: number|null, state: string}} made @returns {number|null} 0..1; null: not known */
export const progressOf = ({ done, total, state }) => (state === 'complete' ? 1 : total ? Math.min(1, done / total) : null);

/**
 * Kind, videos, size and time of a file in one line.
 *
 * @param {Output} output
 * @param {string} videoNames   names of the videos
 */
export function describeOutput(output, videoNames) {
  const { first, stop } = output.options;
  const range =
    output.kind !== 'export' && typeof first === 'number' && typeof stop === 'number' ? `frames ${count(first)} to ${count(stop - 1)}` : '';
  const title =
    output.kind === 'export'
      ? `${KINDS.export.name}: ${output.summary.title ?? output.options.format ?? ''}`
      : (KINDS[output.kind]?.name ?? output.kind);
  return [title, videoNames, range, output.size === null ? '' : bytes(output.size), moment(output.finished ?? output.created)]
    .filter(Boolean)
    .join(' · ');
}

/**
 * The content of a finished export: `12 tracks (train 9, val 3), 840 boxes, 3 files`.
 *
 * @param {Output} output
 */
export function describeContent(output) {
  const counts = output.summary.counts;
  if (counts === null || typeof counts !== 'object' || counts === undefined) return '';
  const splitText = Object.entries(output.summary.split?.tracks ?? {})
    .map(([side, tracks]) => `${side} ${count(tracks)}`)
    .join(', ');
  const parts = Object.entries(counts)
    .filter(([, value]) => typeof value === 'number' && value > 0)
    .map(([name, value]) =>
      `${count(value)} ${value === 1 ? name.replace(/boxes$/, 'box').replace(/s$/, '') : name}${name === 'tracks' && splitText ? ` (${splitText})` : ''}`.replaceAll(
        '_',
        ' ',
      ),
    );
  if (typeof output.summary.files === 'number') parts.push(plural(output.summary.files, 'file'));
  return parts.join(', ');
}

/** Maximum number of labels to name per part. */
const MAX_NAMED_LABELS = 6;

/**
 * Warnings about a finished export: labels that a part of the split lacks, and open tracks that were left out.
 *
 * @param {Output} output
 * @returns {string[]} sentences
 */
export function outputWarnings({ summary }) {
  const splitWarnings = Object.entries(summary.split?.lacks ?? {})
    .filter(([, names]) => Array.isArray(names) && names.length > 0)
    .map(([side, names]) => `The ${side} part has no sign of ${listNames(names.map(String), MAX_NAMED_LABELS)}, which others have.`);
  const open = Number(summary.open_left ?? 0);
  return open > 0 ? [...splitWarnings, `${plural(open, 'open track')} left out: not reviewed or edited yet.`] : splitWarnings;
}

/**
 * The omitted items with reasons.
 *
 * @param {Output} output
 * @returns {{items: {what: string, reason: string}[], total: number}}
 */
export function skippedItems(output) {
  const items = Array.isArray(output.summary.skipped) ? output.summary.skipped : [];
  return { items, total: typeof output.summary.skipped_count === 'number' ? output.summary.skipped_count : items.length };
}
