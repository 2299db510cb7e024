// @ts-check
/** Lays another run or a ground truth over a run, as soon as that one is on the review screen, and goes close to a place. */

import { sizeOf, zoomedTo } from '../model/geometry.js';
import { changeReview, setViewport } from '../store/actions/review.js';

/** A review that has not opened by then is not waited for, ms. */
const PATIENCE = 20_000;
/** How large a place is shown, CSS px. */
const SIDE = 160;

/**
 * @param {import('../page-types.js').App} app
 * @param {string|null} run      on the screen, now or soon; null: whichever it is
 * @param {{second?: {run: string, corrected: boolean}|null, truth?: string|null, video?: string|null}} over   run and ground truth to lie
 *   over it; `video`: on the screen, where no run says it
 * @param {{frame: number, box: import('../types.js').Box, sign: number|null}|null} [place]   what is looked at: its frame, what
 *   has to be in sight, and the sign of the ground truth that is chosen
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
    if (done) return; // the layers that were just shown have led here once more
    // the picture fits itself into its place first; what that shows is the whole of it
    const { review, route } = app.store.get();
    if (place !== null && (review === null || route.screen !== 'review' || review.viewport.zoom === 0 || review.shown !== place.frame))
      return;
    stop();
    // the address that has led here selects a track yet, which lets go of a sign
    if (place !== null)
      queueMicrotask(() =>
        app.store.dispatch((now) =>
          changeReview(setViewport(now, zoomedTo(place.box, SIDE, sizeOf(now.review?.video))), { truthSign: place.sign }),
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
