// @ts-check
/**
 * Distinguishes the moves of a person in the viewer from the viewer's answers to the page.
 *
 * @typedef {object} TimeSync
 * @property {() => void} reset                           a recording is loading
 * @property {() => boolean} hasTime                      whether the viewer has reported a time since then
 * @property {(frame: number) => boolean} request         the page moves to a frame; false: the viewer is already there
 * @property {(frame: number) => boolean} isNewest        whether no later request has been made
 * @property {() => void} giveUp                          forget the requests, because the viewer refuses them
 * @property {(frame: number) => number|null} report      the viewer is at a frame; returns it if a person went there
 */

const MAX_PENDING = 32;

/** @returns {TimeSync} */
export function createTimeSync() {
  /** The frame that both sides know. @type {number|null} */
  let known = null;
  /** Frames that the page has requested and the viewer has not shown yet. @type {number[]} */
  let pending = [];
  let hasTime = false;
  return {
    reset: () => void (hasTime = false),
    hasTime: () => hasTime,
    request(frame) {
      if (frame === known && pending.length === 0) return false;
      pending = [...pending, frame].slice(-MAX_PENDING);
      return true;
    },
    isNewest: (frame) => pending.at(-1) === frame,
    giveUp: () => void (pending = []),
    report(frame) {
      const index = pending.indexOf(frame);
      const isOwn = !hasTime; // a recording opens at a frame that nobody chose, on slow machines long after a request
      hasTime = true;
      if (index >= 0) pending = pending.slice(index + 1);
      const isMove = !isOwn && index < 0 && frame !== known;
      known = frame;
      return isMove ? frame : null;
    },
  };
}
