// @ts-check
/** What stands in place of the review where there is nothing to review. Pure. */

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
