// @ts-check
/** The notice in place of the review if there is nothing to review, and whether the review is still loading. Pure. */

/**
 * @param {import('../state-types.js').State} state
 * @returns {'none'|'waiting'|'unknown'|'gone'}   unknown: the video is not in the library; gone: the run no longer exists
 */
export function reviewNotice({ route, review, videos, runs }) {
  if (route.screen !== 'review') return 'waiting';
  if (videos && !videos.some(({ id }) => id === route.video)) return 'unknown';
  if (!review) return 'waiting';
  // an address may name a removed run; a run that is being opened is already in the list
  const wanted = review.run?.id ?? (review.timebase ? route.run : null);
  const known = runs[review.video.id];
  return wanted !== null && known && !known.some(({ id }) => id === wanted) ? 'gone' : 'none';
}

/**
 * Whether the review at the address is still loading: its run, tracks or edits have not arrived.
 *
 * @param {Pick<import('../state-types.js').State, 'route'|'review'>} state
 * @returns {boolean}
 */
export function isOpening({ route, review }) {
  if (route.screen !== 'review' || review?.video.id !== route.video || review.timebase === null) return true;
  const { run, tracks, seq } = review;
  if (run === null) return route.run !== null;
  if (route.run !== null && route.run !== run.id) return true;
  return seq === null || (tracks === null && !(run.state === 'queued' && run.frames_done === 0));
}
