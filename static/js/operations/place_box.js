// @ts-check
/** Boxes that a person draws, moves and resizes. */

import { toast } from '../core/toast.js';
import { moveBox, normalizeBox, sizeOf } from '../model/geometry.js';
import { selectedTrack } from '../review/shown_tracks.js';
import { askForClass, select, setMode } from '../store/actions/review.js';
import { newKey } from './helpers.js';
import { editWithNotice } from './unseen.js';

/** @typedef {import('../page-types.js').App} App */

/**
 * Handle a box that a person has placed. For a track that is being followed it is another anchor, and nothing is stored
 * until the proposals are accepted; otherwise it is an edit.
 * @param {Pick<App, 'store'|'edit'|'following'>} app
 * @param {string} key
 * @param {number} frame
 * @param {import('../types.js').Box} box
 * @param {string} [gesture]
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function putBox(app, key, frame, box, gesture, notify = toast) {
  if (app.store.get().review?.following?.key === key) app.following.correct({ frame, box });
  else editWithNotice(app, key, () => app.edit({ name: 'set_box', frame, key, box }, undefined, gesture), { notify });
}

/** @param {App} app @param {number} dx @param {number} dy */
export function moveSelectedBox(app, dx, dy) {
  const { review } = app.store.get();
  const shown = selectedTrack(review);
  if (shown && review) putBox(app, shown.key, review.frame, moveBox(shown.box, dx, dy, sizeOf(review.video)), 'move');
}

/** Move the right and lower edges of the box. @param {App} app @param {number} dx @param {number} dy */
export function resizeSelectedBox(app, dx, dy) {
  const { review } = app.store.get();
  const shown = selectedTrack(review);
  if (!shown || !review) return;
  const [x1, y1, x2, y2] = shown.box;
  const resized = normalizeBox([x1, y1, Math.max(x1 + 2, x2 + dx), Math.max(y1 + 2, y2 + dy)], sizeOf(review.video));
  putBox(app, shown.key, review.frame, resized, 'resize');
}

/** Handle a drawn box. @param {Pick<App, 'store'|'edit'|'following'>} app @param {import('../types.js').Box} box @param {boolean} correct   change the selected track instead of making a new one @param {import('../core/toast.js').Notify} [notify] */
export function handleDrawnBox(app, box, correct, notify = toast) {
  const { review } = app.store.get();
  if (!review) return;
  if (correct && review.selected) {
    putBox(app, review.selected, review.frame, box, undefined, notify);
    app.store.dispatch(setMode, 'select');
    return;
  }
  app.store.dispatch(askForClass, { key: newKey(), frame: review.frame, box });
}

/**
 * Make a track from a drawn box.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {import('../state-types.js').Draft} draft
 * @param {number|null} class_id   null: none of the known classes
 * @param {string} [label_key]     key of that label
 */
export function createTrack(app, { key, frame, box }, class_id, label_key) {
  if (app.edit({ name: 'create_track', frame, key, box, class_id, ...(label_key !== undefined && { label_key }) }))
    app.store.dispatch(select, key);
}
