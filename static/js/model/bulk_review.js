// @ts-check
/**
 * One verdict on many tracks. Pure.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc['review']} Review
 * @typedef {import('./track_entries.js').TrackEntry} TrackEntry
 */

/** Maximum number of tracks in one operation. More tracks take several operations, which are undone one by one. */
export const MAX_TRACKS_PER_OPERATION = 500;

/**
 * The shown tracks that a verdict would change.
 *
 * @param {readonly TrackEntry[]} shown
 * @param {{review: Review, openOnly: boolean, maxUncertainty: number}} wanted   uncertainty 0..1
 * @returns {string[]} keys, in the order of the queue
 */
export function tracksToReview(shown, { review, openOnly, maxUncertainty: maxUncertainty }) {
  return shown
    .filter(
      (entry) =>
        entry.review !== review &&
        (!openOnly || entry.review === 'open') &&
        (maxUncertainty >= 1 || (entry.uncertainty !== null && entry.uncertainty <= maxUncertainty)),
    )
    .map(({ key }) => key);
}

/**
 * @param {readonly string[]} keys
 * @param {Review} review
 * @param {number} frame   the frame on the screen
 * @returns {Command[]}
 */
export function reviewCommands(keys, review, frame) {
  /** @type {Command[]} */
  const commands = [];
  for (let at = 0; at < keys.length; at += MAX_TRACKS_PER_OPERATION) {
    const [key, ...others] = keys.slice(at, at + MAX_TRACKS_PER_OPERATION);
    commands.push({ name: 'review_tracks', frame, key, others, review });
  }
  return commands;
}
