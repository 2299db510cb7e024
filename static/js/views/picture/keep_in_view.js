// @ts-check
/** Keeps the selected track visible in a zoomed view of the picture. Independent of the DOM. */

import { panToBox } from '../../model/geometry.js';
import { areBoxesLoading, shownTrack } from '../../review/shown_tracks.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */
/** @typedef {ReviewState['viewport']} Viewport */

/**
 * Whether all boxes of the picture on screen are loaded.
 * @param {Pick<ReviewState, 'frame'|'shown'|'overlays'|'run'>} review
 */
export const areBoxesLoaded = (review) => review.shown === review.frame && !areBoxesLoading(review);

/**
 * Scrolls to a track that was just selected or just got a box in this frame, and follows a track that leaves the view
 * over time. Does nothing if the user has moved the view away from the track or zoomed into a corner of it.
 */
export function createKeepInView() {
  /** @type {string|null} */ let selected = null;
  /** Whether the selected track is not visible yet. */
  let isSearching = false;
  /** The frame in which the selected track had no box. @type {number|null} */
  let missingFrame = null;
  /** The frame and the view in which it was visible last. @type {{frame: number, view: Viewport}|null} */
  let lastVisible = null;

  /**
   * @param {ReviewState} review
   * @param {{width: number, height: number}} screen
   * @param {boolean} showsWholePicture   whether the view shows the whole picture
   * @returns {Viewport} the review's own viewport if nothing has to move
   */
  function nextViewport(review, screen, showsWholePicture) {
    const { frame, viewport } = review;
    isSearching ||= selected !== review.selected;
    if (selected !== review.selected) lastVisible = null;
    selected = review.selected;
    if (showsWholePicture || !selected) {
      isSearching = false;
      lastVisible = null;
      return viewport;
    }
    if (!areBoxesLoaded(review)) return viewport;
    const shown = shownTrack(review, selected);
    const hasLeft = lastVisible !== null && lastVisible.frame !== frame && lastVisible.view === viewport;
    const shouldScroll = isSearching || missingFrame === frame || hasLeft;
    missingFrame = shown ? null : frame;
    isSearching = false;
    if (!shown || review.drag) return viewport;
    const view = panToBox(viewport, screen, shown.box);
    lastVisible = view === viewport || shouldScroll ? { frame, view } : null;
    return shouldScroll ? view : viewport;
  }

  return { nextViewport };
}
