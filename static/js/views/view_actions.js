// @ts-check
/**
 * Functions that lanes, inspector and queue call on the page.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../page-types.js').ViewApp} ViewApp
 */
import { modeOf } from '../modes/index.js';
import { openDialog } from '../store/actions/page.js';
import * as actions from '../store/actions/review.js';

/** @param {ViewApp} app @param {number} frame */
export function seek(app, frame) {
  app.store.dispatch(actions.seek, frame);
}

/** @param {ViewApp} app @param {string|null} key */
export function select(app, key) {
  app.store.dispatch(actions.select, key);
}

/**
 * Handle a click on a track outside the picture: the mode may use it, for example to mark it for a merge.
 *
 * @param {ViewApp} app
 * @param {string} key
 * @returns {boolean} whether the mode used it
 */
export function handleInMode(app, key) {
  const { review } = app.store.get();
  if (review === null || modeOf(review).onTrackClick === null) return false;
  app.store.dispatch(actions.applyTrackClick, key);
  return true;
}

/** @param {ViewApp} app @param {{first: number, last: number}} span */
export function showFrames(app, span) {
  app.store.dispatch(actions.showSpan, span);
}

/** @param {ViewApp} app @param {number|null} tau */
export function setTau(app, tau) {
  app.store.dispatch(actions.dragTau, tau);
}

/** @param {ViewApp} app @param {Partial<import('../state-types.js').QueueFilter>} change */
export function changeFilter(app, change) {
  app.store.dispatch(actions.changeFilter, change);
}

/** @param {ViewApp} app @param {import('../state-types.js').Dialog} dialog */
export function showDialog(app, dialog) {
  app.store.dispatch(openDialog, dialog);
}

/**
 * Edit a track in the frame of the cursor.
 *
 * @param {ViewApp} app
 * @param {string} key
 * @param {Partial<Command> & {name: Command['name']}} fields
 * @param {string|null} [runId]   the run that the edit is for, if another one may be open by now
 * @returns {boolean} whether the edit was made
 */
export function editTrack(app, key, fields, runId) {
  const review = app.store.get().review;
  return review !== null && app.edit({ frame: review.frame, key, ...fields }, runId);
}
