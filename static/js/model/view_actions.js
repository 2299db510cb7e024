// @ts-check
/**
 * The actions that lanes, inspector and queue dispatch: each a pure function state -> state. Outside the review screen
 * they change nothing.
 *
 * @typedef {import('../types.js').State} State
 * @typedef {import('../types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').Command} Command
 */

/**
 * @param {State} state
 * @param {Partial<ReviewState>} change
 * @returns {State} the same object if nothing would change
 */
function withReview(state, change) {
  const review = state.review;
  if (review === null) return state;
  const same = Object.entries(change).every(([name, value]) => Reflect.get(review, name) === value);
  return same ? state : { ...state, review: { ...review, ...change } };
}

/** Put the cursor on a frame of the video. @param {State} state @param {number} frame @returns {State} */
export function seekTo(state, frame) {
  const frames = framesOf(state.review);
  return withReview(state, { frame: Math.min(Math.max(0, Math.floor(frame)), Math.max(0, frames - 1)) });
}

/** @param {State} state @param {string|null} key @returns {State} */
export function selectTrack(state, key) {
  return withReview(state, { selected: key });
}

/** @param {State} state @param {{first: number, last: number}} span @returns {State} */
export function showSpan(state, span) {
  const old = state.review?.span;
  return old && old.first === span.first && old.last === span.last ? state : withReview(state, { span });
}

/** @param {State} state @param {number|null} tau   null: the run's @returns {State} */
export function dragTau(state, tau) {
  return withReview(state, { tau });
}

/** @param {State} state @param {Partial<import('../types.js').QueueFilter>} change @returns {State} */
export function changeFilter(state, change) {
  return state.review === null ? state : withReview(state, { filter: { ...state.review.filter, ...change } });
}

/** @param {State} state @param {import('../types.js').Dialog|null} dialog @returns {State} */
export function openDialog(state, dialog) {
  return { ...state, dialog };
}

/**
 * Number of frames of the video on the review screen.
 *
 * @param {ReviewState|null} review
 * @returns {number} at least 1
 */
export function framesOf(review) {
  return Math.max(1, review?.video.frames ?? 1);
}

/**
 * A command for one track, with the span that the server needs for an engine's track without a document.
 *
 * @param {ReviewState} review
 * @param {string} key
 * @param {Partial<Command> & {name: Command['name']}} fields
 * @returns {Command}
 */
export function commandOn(review, key, fields) {
  /** @type {Command} */
  const command = { frame: review.frame, key, ...fields };
  if (key.startsWith('m') && review.docs[key] === undefined && review.tracks !== null) {
    const i = review.tracks.id.indexOf(Number(key.slice(1)));
    if (i >= 0) command.spans = [{ track: review.tracks.id[i], first: review.tracks.first[i], last: review.tracks.last[i] }];
  }
  return command;
}
