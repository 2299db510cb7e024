// @ts-check
/** Frames of engine tracks without a box, as app/evidence/service.py finds them. Pure. */
import { OPEN_END } from './documents.js';

/** Most gaps that the server takes with a command. */
const MAX_GAPS = 1000;

/**
 * The gaps of engine tracks after their first box. A track that has no box in the newest frame has ended, so its last gap
 * has no end. The server finds the gaps itself; these are for the page until it has answered.
 * @param {import('../types.js').LaneColumns|null} lanes   sorted by track, then frame
 * @param {ReadonlySet<number>} tracks
 * @returns {import('../types.js').Segment[]}
 */
export function engineGaps(lanes, tracks) {
  if (lanes === null) return [];
  const newest = lanes.last.reduce((a, b) => Math.max(a, b), 0);
  return lanes.track
    .flatMap((track, i) => {
      if (!tracks.has(track)) return [];
      const goesOn = lanes.track[i + 1] === track;
      const first = lanes.last[i] + 1;
      const last = goesOn ? lanes.first[i + 1] - 1 : OPEN_END;
      return first <= last && (goesOn || lanes.last[i] < newest) ? [{ track, first, last }] : [];
    })
    .slice(0, MAX_GAPS);
}
