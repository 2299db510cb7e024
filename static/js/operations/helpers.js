// @ts-check
/**
 * Helpers of several operations.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../page-types.js').Operation} Operation
 * @typedef {import('../types.js').Command} Command
 */
import { reviewNotice } from '../model/review_notice.js';
import { areBoxesLoading, selectedTrack } from '../review/shown_tracks.js';
import { randomId } from '../core/random_id.js';

/** @param {State} state */
export const onReview = (state) => state.route.screen === 'review' && state.review?.timebase != null && reviewNotice(state) === 'none';

/** Editing needs a run, because edits belong to a run. @param {State} state @returns {string|null} */
export const needsRun = ({ review }) => (review?.run ? null : 'Run the engine on this video first, or choose “Annotate by hand”.');

/** @param {State} state @returns {string|null} */
export const needsTrack = (state) => needsRun(state) ?? (state.review?.selected ? null : 'Select a track first.');

/** The reason to wait while it is not known whether the track has a box in this frame. @param {State} state @returns {string|null} */
export const needsLoadedBoxes = (state) =>
  needsTrack(state) ??
  (state.review && areBoxesLoading(state.review) && !selectedTrack(state.review) ? 'The boxes of this frame are still loading.' : null);

/** @param {State} state @returns {string|null} */
export const needsBox = (state) => needsLoadedBoxes(state) ?? (selectedTrack(state.review) ? null : 'The track has no box in this frame.');

/**
 * An operation with defaults: on the review screen, never disabled, once per key press.
 * @param {Omit<Operation, 'available'|'disabled'|'tooltip'|'repeats'> & Partial<Operation>} fields
 * @returns {Operation}
 */
export const operation = (fields) => ({
  available: onReview,
  disabled: () => null,
  repeats: false,
  tooltip: fields.keys.length ? `${fields.label} (${fields.keys[0]})` : fields.label,
  ...fields,
});

/**
 * Edit the selected track in the frame of the cursor.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {Partial<Command> & {name: Command['name']}} fields
 * @param {string} [gesture]   edits of one gesture without a pause are one undo step
 * @returns {boolean} whether the edit was made; false: no track is selected, or the edit was refused
 */
export function editSelected(app, fields, gesture) {
  const { review } = app.store.get();
  return Boolean(review?.selected && app.edit({ frame: review.frame, key: review.selected, ...fields }, undefined, gesture));
}

/** A key for a new track. */
export const newKey = () => `h${randomId().replaceAll('-', '').slice(0, 16)}`;
