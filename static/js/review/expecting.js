// @ts-check
/**
 * Tells the server where a person looks at a box, or is about to draw one: followed from there, the first proposals come
 * at once if the video has been decoded that far.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').State} State
 */
import { may } from '../model/team.js';
import { shownTrack } from './shown_tracks.js';

/** How long a person looks at a frame before it is worth decoding, ms. */
const REST = 150;

/** The frame to follow from; null: nothing there can be followed now. @param {State} state */
function placeOf({ review, session }) {
  if (!review?.run || review.playing || review.following || review.shown !== review.frame || !may(session, 'annotator')) return null;
  const box = review.mode === 'draw' || (review.selected !== null && shownTrack(review, review.selected) !== null);
  return box ? { run: review.run.id, frame: review.frame } : null;
}

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'expectFollow'>, signal: AbortSignal}} setup
 * @returns {{sync: () => void}} sync: the state has changed
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
      // without an answer it only takes longer
      if (now) resting = setTimeout(() => void api.expectFollow(now.run, now.frame, { signal }).catch(() => {}), REST);
    },
  };
}
