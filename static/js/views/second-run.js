// @ts-check
/** Lays one run over another, as soon as that one is on the review screen. */

/** A review that has not opened by then is not waited for, ms. */
const PATIENCE = 20_000;

/**
 * @param {import('../page-types.js').App} app
 * @param {string|null} run      on the screen, now or soon
 * @param {string|null} second   to lie over it
 */
export function showOver(app, run, second) {
  if (!run || !second || run === second) return;
  /** @param {import('../types.js').State} state */
  function check(state) {
    if (state.review?.run?.id !== run || !state.review.timebase) return;
    stop();
    app.loader.showSecond(second);
  }
  const leave = app.store.subscribe(check);
  const timer = setTimeout(stop, PATIENCE);
  function stop() {
    clearTimeout(timer);
    leave();
  }
  check(app.store.get());
}
