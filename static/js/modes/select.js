// @ts-check
/** The default mode: a click selects a track, a drag moves or resizes its box. */

import { whyNoBox } from '../model/no_box.js';
import { NO_RUN } from '../model/no_tracks.js';

/** @type {import('./index.js').Mode} */
export const select = {
  enter: () => ({}),
  exit: () => ({}),
  changesBoxes: true,
  cursor: null,
  take: null,
  hint({ selected, docs, run }, absent) {
    if (selected) return absent ? whyNoBox(selected, docs[selected]) : '';
    return run ? 'Click a box to select its track' : NO_RUN;
  },
};
