// @ts-check
/** The default mode: a click selects a track, a drag moves or resizes its box. */

import { whyNoBox } from '../model/missing_box.js';
import { NO_RUN } from '../model/no_tracks.js';

/** @type {import('./index.js').Mode} */
export const select = {
  enter: () => ({}),
  exit: () => ({}),
  changesBoxes: true,
  cursor: null,
  onTrackClick: null,
  hint({ selected, docs, run }, hasNoBox) {
    if (selected) return hasNoBox ? whyNoBox(selected, docs[selected]) : '';
    return run ? 'Click a box to select its track' : NO_RUN;
  },
};
