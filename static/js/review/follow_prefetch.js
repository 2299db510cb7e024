// @ts-check
/**
 * Tells the server when a person selects a box or is about to draw one. The server then decodes the video up to this
 * frame, so that a follow from it gets its first proposals at once.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 */
import { hasRole } from '../model/team.js';
import { shownTrack } from './shown_tracks.js';

/** Time on a frame before it is worth decoding, ms. */
const DWELL_MS = 150;

/** The frame to follow from; null: nothing can be followed there now. @param {State} state */
function followStart({ review, session }) {
  if (!review?.run || review.playing || review.following || review.shown !== review.frame || !hasRole(session, 'annotator')) return null;
  const box = review.mode === 'draw' || (review.selected !== null && shownTrack(review, review.selected) !== null);
  return box ? { run: review.run.id, frame: review.frame } : null;
}

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'expectFollow'>, signal: AbortSignal}} setup
 * @returns {{sync: () => void}} sync: follow a change of the state
 */
export function createFollowPrefetch({ store, api, signal }) {
  /** @type {{run: string, frame: number}|null} */
  let announced = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;
  signal.addEventListener('abort', () => clearTimeout(timer), { once: true });
  return {
    sync() {
      const start = followStart(store.get());
      if (start?.run === announced?.run && start?.frame === announced?.frame) return;
      announced = start;
      clearTimeout(timer);
      // a failed request only makes the first proposals slower
      if (start) timer = setTimeout(() => void api.expectFollow(start.run, start.frame, { signal }).catch(() => {}), DWELL_MS);
    },
  };
}
