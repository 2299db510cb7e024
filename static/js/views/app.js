// @ts-check
/**
 * What a view needs of the page, and the few things that lanes, inspector and queue do with it.
 *
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../types.js').Command} Command
 *
 * @typedef {object} ViewApp
 * @property {{get: () => State, dispatch: (action: (state: State) => State) => void}} store
 * @property {import('../api/client.js').Api} api
 * @property {import('../store/catch_up.js').CatchUp['load']} load   what the server is asked, into the store, never older than what was heard
 * @property {(command: Command, of?: string|null) => boolean} edit   apply at once, send, keep until the server has it;
 *   `of`: the run that it is meant for
 * @property {import('./note_drafts.js').NoteDrafts} notes   those that are half written
 */
import { openDialog } from '../store/actions/page.js';
import * as actions from '../store/actions/review.js';

/** @param {ViewApp} app @param {number} frame */
export function seek(app, frame) {
  app.store.dispatch((state) => actions.seek(state, frame));
}

/** @param {ViewApp} app @param {string|null} key */
export function select(app, key) {
  app.store.dispatch((state) => actions.select(state, key));
}

/**
 * A track was clicked outside the picture: while tracks are merged it is marked, or no longer.
 *
 * @param {ViewApp} app
 * @param {string} key
 * @returns {boolean} whether it was for the merge
 */
export function mark(app, key) {
  if (app.store.get().review?.mode !== 'merge') return false;
  app.store.dispatch((state) => actions.toggleMarked(state, key));
  return true;
}

/** @param {ViewApp} app @param {{first: number, last: number}} span */
export function show(app, span) {
  app.store.dispatch((state) => actions.showSpan(state, span));
}

/** @param {ViewApp} app @param {number|null} tau */
export function setTau(app, tau) {
  app.store.dispatch((state) => actions.dragTau(state, tau));
}

/** @param {ViewApp} app @param {Partial<import('../state-types.js').QueueFilter>} change */
export function filter(app, change) {
  app.store.dispatch((state) => actions.changeFilter(state, change));
}

/** @param {ViewApp} app @param {import('../state-types.js').Dialog} dialog */
export function dialog(app, dialog) {
  app.store.dispatch((state) => openDialog(state, dialog));
}

/**
 * Edit a track in the frame of the cursor.
 *
 * @param {ViewApp} app
 * @param {string} key
 * @param {Partial<Command> & {name: Command['name']}} fields
 * @param {string|null} [of]   the run that it is meant for, where another one may be open by now
 * @returns {boolean} whether it is done
 */
export function edit(app, key, fields, of) {
  const review = app.store.get().review;
  return review !== null && app.edit({ frame: review.frame, key, ...fields }, of);
}
