// @ts-check
/** Lays another run or a ground truth over a run, as soon as that one is on the review screen. */

/** A review that has not opened by then is not waited for, ms. */
const PATIENCE = 20_000;

/**
 * @param {import('../page-types.js').App} app
 * @param {string|null} run      on the screen, now or soon; null: whichever it is
 * @param {{second?: {run: string, corrected: boolean}|null, truth?: string|null, video?: string|null}} over   run and ground truth to lie
 *   over it; `video`: on the screen, where no run says it
 */
export function openOver(app, run, {second = null, truth = null, video = null}) {
  if (second === null && truth === null) return;
  /** @param {import('../state-types.js').State} state */
  function check(state) {
    if (!state.review?.timebase || (run !== null && state.review.run?.id !== run) || (video !== null && state.review.video.id !== video)) return;
    stop();
    if (second !== null) app.loader.showSecond(second.run, second.corrected);
    if (truth !== null) app.loader.showTruth(truth);
  }
  const leave = app.store.subscribe(check);
  const timer = setTimeout(stop, PATIENCE);
  function stop() {
    clearTimeout(timer);
    leave();
  }
  check(app.store.get());
}
