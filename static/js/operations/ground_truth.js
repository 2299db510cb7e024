// @ts-check
/** Choosing a sign of the ground truth, and taking it over. */

import { NO_CLASS } from '../model/documents.js';
import { chosenTruth, nextTruth } from '../review/chosen_truth.js';
import { labelName } from '../model/labels.js';
import { select, selectTruth } from '../store/actions/review.js';
import { takeOver } from '../review/take_over.js';
import { createTrack, putBox } from './place_box.js';
import { needsRun, newKey, onReview, operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const GROUP = 'Ground truth';

/** @param {State} state */
const isShown = (state) => onReview(state) && Boolean(state.review?.layers.truth && state.review.truthId !== null);

/** @param {State} state @returns {string|null} */
const needsSign = (state) =>
  needsRun(state) ?? (state.review && chosenTruth(state.review) ? null : 'Choose a box of the ground truth first: click it, or press Y.');

/** @param {State} state @returns {string|null} */
const needsTruthBox = (state) =>
  needsSign(state) ?? (state.review && chosenTruth(state.review)?.box ? null : 'The ground truth has no box of this sign here.');

/**
 * Take over the box in this frame: the track that it overlaps gets it, else it becomes a new track.
 * @param {App} app
 */
function takeOverBox(app) {
  const { review } = app.store.get();
  const chosen = review && chosenTruth(review);
  if (!review || !chosen?.box) return;
  if (chosen.on) {
    const { key } = chosen.on;
    putBox(app, key, review.frame, chosen.box);
    app.store.dispatch(select, key);
  } else {
    createTrack(app, { key: newKey(), frame: review.frame, box: chosen.box }, chosen.class_id ?? NO_CLASS);
  }
}

/**
 * @param {App} app
 * @param {(chosen: import('../review/chosen_truth.js').ChosenTruth) => {signs: number[]}|{label: number}} which
 */
function takeOverSigns(app, which) {
  const { review } = app.store.get();
  const chosen = review && chosenTruth(review);
  if (review?.run && review.truthId !== null && chosen) void takeOver(app, review.run.id, { truth: review.truthId, ...which(chosen) });
}

/** The label of the chosen sign. @param {State} state */
export const truthLabel = ({ review, labels }) => labelName(labels, (review && chosenTruth(review)?.class_id) ?? NO_CLASS);

/** @type {import('../page-types.js').Operation[]} */
export const groundTruth = [
  operation({
    id: 'next-truth',
    label: 'Next box of the ground truth',
    keys: ['Y'],
    icon: 'truth',
    group: GROUP,
    available: isShown,
    tooltip: 'Choose the next box of the ground truth in this frame (Y)',
    disabled: (state) => (state.review && nextTruth(state.review) !== null ? null : 'The ground truth has no box in this frame.'),
    run: (app) => {
      const { review } = app.store.get();
      const sign = review && nextTruth(review);
      if (sign !== null) app.store.dispatch(selectTruth, sign);
    },
  }),
  operation({
    id: 'take-truth-box',
    label: 'Take this box over',
    keys: ['Shift+Y'],
    group: GROUP,
    available: isShown,
    disabled: needsTruthBox,
    tooltip: 'The track that it overlaps gets the box; otherwise it becomes a new track (Shift+Y)',
    run: takeOverBox,
  }),
  operation({
    id: 'take-truth-sign',
    label: 'Take the whole sign over',
    keys: ['Alt+Y'],
    group: GROUP,
    available: isShown,
    disabled: needsSign,
    tooltip: 'All boxes and the label of this sign; one undo reverts this (Alt+Y)',
    run: (app) => takeOverSigns(app, ({ sign }) => ({ signs: [sign] })),
  }),
  operation({
    id: 'take-truth-label',
    label: 'Take all signs of this label over',
    keys: ['Alt+Shift+Y'],
    group: GROUP,
    available: isShown,
    disabled: needsTruthBox,
    tooltip: 'All signs of the ground truth that have this label; one undo reverts this (Alt+Shift+Y)',
    run: (app) => takeOverSigns(app, ({ class_id }) => ({ label: class_id ?? NO_CLASS })),
  }),
];
