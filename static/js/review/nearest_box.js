// @ts-check
/**
 * The box of a track nearest in time to a frame without a box. It is copied there to be corrected. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').Box} Box
 */

/**
 * @param {ReviewState} review
 * @param {string} key
 * @returns {{frame: number, box: Box}|null} null: no box is known in any frame; engine boxes are known only from loaded lanes
 */
export function nearestBox(review, key) {
  const { frame } = review;
  const doc = review.docs[key];
  const id = key.startsWith('m') ? Number(key.slice(1)) : null;
  const segments = doc ? doc.segments : id === null ? [] : [{ track: id, first: 0, last: Infinity }];
  /** @type {{frame: number, box: Box}|null} */
  let best = null;
  /** @param {number} at @param {Box|null} box */
  const consider = (at, box) => {
    if (box !== null && (best === null || Math.abs(at - frame) < Math.abs(best.frame - frame))) best = { frame: at, box };
  };
  for (const [at, { box }] of Object.entries(doc?.keys ?? {})) consider(Number(at), box);
  for (const { track, first, last } of segments) {
    const lane = review.laneOf[track];
    lane?.frame.forEach((at, i) => {
      if (first <= at && at <= last) consider(at, lane.box[i]);
    });
  }
  return best;
}
