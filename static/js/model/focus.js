// @ts-check
/** The focus of expansion of a run's camera: the point from which signs move away as they come nearer. Pure. */

/** @typedef {import('../types.js').Run} Run */

/**
 * @param {Run|null} run
 * @param {{width: number|null, height: number|null}} video   px
 * @returns {[number, number]|null} px of the picture; null: not known, or the run is not complete
 */
export function focusPoint(run, video) {
  const focus = run?.summary.focus;
  return focus && video.width !== null && video.height !== null ? [focus.x * video.width, focus.y * video.height] : null;
}

/** @param {Run} run @returns {string|null} the focus in words; null: not known */
export function describeFocus(run) {
  const focus = run.summary.focus;
  return focus ? `${focus.y.toFixed(3)} of the height, ${focus.named ? 'as it was named' : 'estimated from the drive'}` : null;
}
