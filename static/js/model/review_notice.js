// @ts-check
/** What stands in place of the review where there is nothing to review, and whether all of it is there. Pure. */

/**
 * @param {import('../state-types.js').State} state
 * @returns {'none'|'waiting'|'unknown'|'gone'}   unknown: the video is not in the library; gone: the run is not there any more
 */
export function reviewNotice({ route, review, videos, runs }) {
  if (route.screen !== 'review') return 'waiting';
  if (videos && !videos.some(({ id }) => id === route.video)) return 'unknown';
  if (!review) return 'waiting';
  // an address may name a run that was removed; one that is on its way here is in the list before it opens
  const wanted = review.run?.id ?? (review.timebase ? route.run : null);
  const known = runs[review.video.id];
  return wanted !== null && known && !known.some(({ id }) => id === wanted) ? 'gone' : 'none';
}

/**
 * Whether the review that the address names is still on its way here: its run, tracks or edits have not come.
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
