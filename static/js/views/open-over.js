// @ts-check
/**
 * Shows another run or a ground truth on top of a run as soon as that run is on the review screen, and zooms to a
 * place.
 */

import { sizeOf, zoomToBox } from '../model/geometry.js';
import { changeReview, setViewport } from '../store/actions/review.js';

/** The longest wait for a review to open, ms. */
const PATIENCE = 20_000;
/** Size of a place after the zoom, CSS px. */
const SIDE = 160;

/**
 * @param {import('../page-types.js').App} app
 * @param {string|null} run      the run on the screen, now or soon; null: any
 * @param {{second?: {run: string, corrected: boolean}|null, truth?: string|null, video?: string|null}} over   run and
 *   ground truth to show on top; `video`: the video on the screen, if no run is given
 * @param {{frame: number, box: import('../types.js').Box, sign: number|null}|null} [place]   the place to show: its
 *   frame, the box that must be visible, and the chosen sign of the ground truth
 */
export function openOver(app, run, { second = null, truth = null, video = null }, place = null) {
  if (second === null && truth === null && place === null) return;
  let layered = false;
  let done = false;
  /** @param {import('../state-types.js').State} state */
  function check(state) {
    if (!state.review?.timebase || (run !== null && state.review.run?.id !== run) || (video !== null && state.review.video.id !== video))
      return;
    if (!layered) {
      layered = true;
      if (second !== null) app.loader.showSecond(second.run, second.corrected);
      if (truth !== null) app.loader.showTruth(truth);
    }
    if (done) return; // showing the layers has triggered this again
    // the picture first fits itself into its place, which shows all of it
    const { review, route } = app.store.get();
    if (place !== null && (review === null || route.screen !== 'review' || review.viewport.zoom === 0 || review.shown !== place.frame))
      return;
    stop();
    // the address still selects a track, which deselects a sign
    if (place !== null)
      queueMicrotask(() =>
        app.store.dispatch((now) =>
          changeReview(setViewport(now, zoomToBox(place.box, SIDE, sizeOf(now.review?.video))), { truthSign: place.sign }),
        ),
      );
  }
  const leave = app.store.subscribe(check);
  const timer = setTimeout(stop, PATIENCE);
  function stop() {
    done = true;
    clearTimeout(timer);
    leave();
  }
  check(app.store.get());
}
