// @ts-check
/** The sources of a retraining, in words. Pure. */
import { plural } from './format.js';

/**
 * The present review of a video.
 *
 * @typedef {object} ReviewSource
 * @property {string} run
 * @property {string} run_name
 * @property {string} video
 * @property {string} video_name
 * @property {number} edit_revision   revision of its newest edit
 * @property {number} accepted
 * @property {number} rejected        false positives
 * @property {number} left            tracks without a decision
 */

/** @typedef {{id: string, edits: number, undone: number, gone: string[]}} ExportAge   changes of the exported reviews since the export */

/** @typedef {'finished'|'begun'|'all'} ReviewChoice */

/** The choices of videos. @type {Record<ReviewChoice, string>} */
export const REVIEW_CHOICES = { finished: 'Finished: nothing is open', begun: 'Begun: something is decided', all: 'All with corrections' };

/** @param {ReviewSource} source @param {ReviewChoice} choice */
export const isChosen = ({ accepted, rejected, left }, choice) =>
  choice === 'all' || (accepted + rejected > 0 && (choice === 'begun' || left === 0));

/** The narrowest choice that contains a video. @param {readonly ReviewSource[]} sources @returns {ReviewChoice} */
export const defaultChoice = (sources) =>
  /** @type {const} */ (['finished', 'begun', 'all']).find((choice) => sources.some((one) => isChosen(one, choice))) ?? 'all';

/** What the review of a video contributes, and its progress. @param {ReviewSource} source */
export function describeReview({ accepted, rejected, left, edit_revision }) {
  const parts = [
    `${accepted} accepted`,
    rejected > 0 && plural(rejected, 'false positive'),
    left > 0 && `${left} undecided, not used unless edited`,
  ];
  return `${parts.filter(Boolean).join(', ')}${edit_revision > 0 ? ` · up to edit ${edit_revision}` : ''}`;
}

/** A warning about the age of a file before training; empty if nothing has changed since. @param {ExportAge|undefined} age */
export function describeAge(age) {
  if (!age) return '';
  const { edits, undone, gone } = age;
  const sentences = [];
  if (gone.length > 0)
    sentences.push(`The run of ${gone.join(', ')} no longer exists: whether its corrections are still valid is not known.`);
  if (edits > 0) sentences.push(`Out of date: ${edits === 1 ? '1 edit was' : `${edits} edits were`} made since.`);
  if (undone > 0)
    sentences.push(
      `${undone === 1 ? '1 edit that it holds was' : `${undone} edits that it holds were`} undone since, but would still be used for training.`,
    );
  return sentences.join(' ');
}
