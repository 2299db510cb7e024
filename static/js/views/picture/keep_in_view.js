// @ts-check
/** A view that shows a part of the picture keeps the selected track in sight. Knows no DOM. */

import { revealed } from '../../model/geometry.js';
import { isAwaited, shownTrack } from '../../review/shown_tracks.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */
/** @typedef {ReviewState['viewport']} Viewport */

/**
 * Whether all boxes of the picture on screen are there: those of the next one may still be on their way.
 * @param {Pick<ReviewState, 'frame'|'shown'|'overlays'|'run'>} review
 */
export const settledAt = (review) => review.shown === review.frame && !isAwaited(review);

/**
 * Brings a track into sight that has just been selected or has just got a box here, and follows one that leaves the sight
 * as time goes on. Whoever has moved the view away from it, or looks at a corner of it closely, is left in peace.
 */
export function createKeepInView() {
  /** @type {string|null} */
  let selected = null;
  /** The track has been selected and is not in sight yet. */
  let searching = false;
  /** The frame in which the selected track was seen to have no box. @type {number|null} */
  let lacking = null;
  /** Where it was in sight last, and in which view. @type {{frame: number, view: Viewport}|null} */
  let held = null;

  /**
   * @param {ReviewState} review
   * @param {{width: number, height: number}} screen
   * @param {boolean} whole   the view shows the whole picture
   * @returns {Viewport} that of the review if nothing is to be moved
   */
  function viewOf(review, screen, whole) {
    const { frame, viewport } = review;
    searching ||= selected !== review.selected;
    if (selected !== review.selected) held = null;
    selected = review.selected;
    if (whole || !selected) {
      searching = false;
      held = null;
      return viewport;
    }
    if (!settledAt(review)) return viewport;
    const shown = shownTrack(review, selected);
    const left = held !== null && held.frame !== frame && held.view === viewport;
    const wanted = searching || lacking === frame || left;
    lacking = shown ? null : frame;
    searching = false;
    if (!shown || review.drag) return viewport;
    const view = revealed(viewport, screen, shown.box);
    held = view === viewport || wanted ? { frame, view } : null;
    return wanted ? view : viewport;
  }

  return { viewOf };
}
