// @ts-check
/**
 * Which engine tracks a track on screen is made of. Pure.
 *
 * @typedef {import('../types.js').ReviewState} ReviewState
 */

/**
 * @param {ReviewState} review
 * @param {string} key
 * @returns {number[]} engine tracks, in order of frames
 */
export function segmentsOf(review, key) {
  const doc = review.docs[key];
  if (doc) return [...new Set(doc.segments.map(({ track }) => track))];
  return key.startsWith('m') ? [Number(key.slice(1))] : [];
}
