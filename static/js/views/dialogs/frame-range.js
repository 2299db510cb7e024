// @ts-check
/** First and last frame of a part of a run, initially around the selected track. */

import { docOf } from '../../editing/revisions.js';
import { shownSpan } from '../../model/effective.js';
import { parseNumber } from '../../model/exchange.js';
import { trackName } from '../../model/track_name.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { field, numberInput } from './fields.js';

/** Margin before and after a track, frames. */
const MARGIN = 15;

/**
 * Frames around a track, or around the cursor, within those of a run.
 *
 * @param {{frame: number, span: {first: number, last: number}|null, first: number, last: number, most: number}} where   last: inclusive
 * @returns {{first: number, last: number}}
 */
export function rangeAround({ frame, span, first, last, most }) {
  let from = Math.max(first, (span?.first ?? frame - most / 2 + MARGIN) - MARGIN);
  let to = Math.min(last, (span?.last ?? frame + most / 2 - 1 - MARGIN) + MARGIN);
  if (to - from + 1 > most) {
    const middle = Math.min(Math.max(frame, from), to);
    from = Math.max(from, Math.min(middle - Math.floor(most / 2), to - most + 1));
    to = from + most - 1;
  }
  return { first: Math.floor(from), last: Math.floor(to) };
}

/**
 * The reason for the initial range.
 *
 * @param {string|null} track   name of the selected track; null: none
 * @param {boolean} whole       the frames are those of the whole run
 */
export function rangeWords(track, whole) {
  if (whole)
    return track === null
      ? 'All frames of the run.'
      : `All frames of the run: the selected track ${track} with ${MARGIN} frames around it needs all of them.`;
  return track === null
    ? 'Around the frame on screen; select a track first to get the frames around it.'
    : `Around the selected track ${track}.`;
}

/**
 * @param {import('../../state-types.js').ReviewState|null} review
 * @param {{id: string, begin: number, most: number, changed: (wrong: string) => void}} options   begin: maximum length of the initial range, frames; most: of any range
 */
export function createFrameRange(review, { id, begin, most, changed }) {
  const run = review?.run;
  const first = run?.first ?? 0;
  const last = Math.max(first, first + (run?.frames_done ?? 1) - 1);
  const doc = review?.selected ? docOf(review, review.selected) : null;
  const span = doc && shownSpan(doc, review?.tracks);
  const offered = rangeAround({ frame: review?.frame ?? 0, span, first, last, most: begin });
  const from = numberInput(`${id}-first`, String(offered.first), tell, { inputmode: 'numeric' });
  const to = numberInput(`${id}-last`, String(offered.last), tell, { inputmode: 'numeric' });
  const length = h('span.muted.small.export-count', { role: 'status' });

  /** @returns {{first: number, stop: number}|{error: string}} */
  function value() {
    const low = parseNumber(from.value, { name: 'The first frame', low: first, high: last, whole: true });
    if ('error' in low) return low;
    const high = parseNumber(to.value, { name: 'The last frame', low: first, high: last, whole: true });
    if ('error' in high) return high;
    const frames = Number(high.value) - Number(low.value) + 1;
    if (frames < 1) return { error: 'The last frame comes before the first.' };
    if (frames > most) return { error: `${plural(frames, 'frame')} are too many; at most ${most} are allowed.` };
    return { first: Number(low.value), stop: Number(high.value) + 1 };
  }

  function tell() {
    const found = value();
    setText(length, 'error' in found ? '' : plural(found.stop - found.first, 'frame'));
    changed('error' in found ? found.error : '');
  }

  const whole = offered.first === first && offered.last === last;
  const element = h(
    'div.stack',
    h('div.export-pair', field('First frame', from), field('Last frame', to)),
    h('p.row', h('span.field-hint.grow', rangeWords(doc && review?.selected ? trackName(review.selected, doc) : null, whole)), length),
  );
  return { element, value, tell, focus: from };
}
