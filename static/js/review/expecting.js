// @ts-check
/**
 * Tells the server when a person looks at a box or is about to draw one. The server then decodes the video up to there,
 * so that a follow from that frame gets its first proposals at once.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 */
import { may } from '../model/team.js';
import { shownTrack } from './shown_tracks.js';

/** Time on a frame before it is worth decoding, ms. */
const REST = 150;

/** The frame to follow from; null: nothing can be followed there now. @param {State} state */
function placeOf({ review, session }) {
  if (!review?.run || review.playing || review.following || review.shown !== review.frame || !may(session, 'annotator')) return null;
  const box = review.mode === 'draw' || (review.selected !== null && shownTrack(review, review.selected) !== null);
  return box ? { run: review.run.id, frame: review.frame } : null;
}

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'expectFollow'>, signal: AbortSignal}} setup
 * @returns {{sync: () => void}} sync: follow a change of the state
 */
export function createExpecting({ store, api, signal }) {
  /** @type {{run: string, frame: number}|null} */
  let place = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let resting;
  signal.addEventListener('abort', () => clearTimeout(resting), { once: true });
  return {
    sync() {
      const now = placeOf(store.get());
      if (now?.run === place?.run && now?.frame === place?.frame) return;
      place = now;
      clearTimeout(resting);
      // a failed request only makes the first proposals slower
      if (now) resting = setTimeout(() => void api.expectFollow(now.run, now.frame, { signal }).catch(() => {}), REST);
    },
  };
}
