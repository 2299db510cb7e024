// @ts-check
/** Time of a frame from the video's frame table, else from its rate while the table is loading. */

/**
 * @param {import('../../state-types.js').ReviewState} review
 * @param {number} frame
 * @returns {number} s from the first frame
 */
export function secondsOf(review, frame) {
  if (review.timebase !== null) return review.timebase.secondsAt(frame);
  const { rate, frames, duration } = review.video;
  return frame / (rate ?? (frames && duration ? frames / duration : 25));
}
