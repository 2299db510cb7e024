// @ts-check
/**
 * Shows another run or a ground truth on top of a run as soon as that run is on the review screen, and zooms to a
 * place.
 */

import { sizeOf, zoomToBox } from '../model/geometry.js';
import { changeReview, setViewport } from '../store/actions/review.js';

/** The longest wait for a review to open, ms. */
const MAX_WAIT_MS = 20_000;
/** Size of a place after the zoom, CSS px. */
const ZOOMED_SIZE_PX = 160;

/**
 * @param {import('../page-types.js').App} app
 * @param {string|null} run      the run on the screen, now or soon; null: any
 * @param {{second?: {run: string, corrected: boolean}|null, truth?: string|null, video?: string|null}} over   run and
 *   ground truth to show on top; `video`: the video on the screen, if no run is given
 * @param {{frame: number, box: import('../types.js').Box, sign: number|null}|null} [target]   the place to show: its
 *   frame, the box that must be visible, and the chosen sign of the ground truth
 */
export function showInReview(app, run, { second = null, truth = null, video = null }, target = null) {
  if (second === null && truth === null && target === null) return;
  let areLayersShown = false;
  let isDone = false;
  /** @param {import('../state-types.js').State} state */
  function check(state) {
    if (!state.review?.timebase || (run !== null && state.review.run?.id !== run) || (video !== null && state.review.video.id !== video))
      return;
    if (!areLayersShown) {
      areLayersShown = true;
      if (second !== null) app.loader.showSecond(second.run, second.corrected);
      if (truth !== null) app.loader.showTruth(truth);
    }
    if (isDone) return; // showing the layers has triggered this again
    // the picture first fits itself into its place, which shows all of it
    const { review, route } = app.store.get();
    if (target !== null && (review === null || route.screen !== 'review' || review.viewport.zoom === 0 || review.shown !== target.frame))
      return;
    stop();
    // the address still selects a track, which deselects a sign
    if (target !== null)
      queueMicrotask(() =>
        app.store.dispatch((now) =>
          changeReview(setViewport(now, zoomToBox(target.box, ZOOMED_SIZE_PX, sizeOf(now.review?.video))), { truthSign: target.sign }),
        ),
      );
  }
  const unsubscribe = app.store.subscribe(check);
  const timer = setTimeout(stop, MAX_WAIT_MS);
  function stop() {
    isDone = true;
    clearTimeout(timer);
    unsubscribe();
  }
  check(app.store.get());
}
