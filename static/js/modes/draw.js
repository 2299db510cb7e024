// @ts-check
/** Draw mode: a drag makes the box of a new track; with Shift it corrects the selected track. */

/** @type {import('./index.js').Mode} */
export const draw = {
  enter: () => ({}),
  exit: () => ({}),
  changesBoxes: false,
  cursor: 'crosshair',
  onTrackClick: null,
  hint: () => 'Drag a box for a new track. Hold Shift to correct the selected one. Escape ends.',
};
