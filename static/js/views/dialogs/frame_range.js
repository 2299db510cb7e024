// @ts-check
/** First and last frame of a part of a run, initially around the selected track. */

import { docOf } from '../../editing/revisions.js';
import { shownSpan } from '../../model/effective.js';
import { parseFrames } from '../../model/exchange.js';
import { trackName } from '../../model/track_name.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { field, numberInput } from './fields.js';

/** Margin before and after a track, frames. */
const MARGIN = 15;

/**
 * Frames around a track, or around the cursor, within those of a run.
 *
 * @param {{frame: number, span: {first: number, last: number}|null, first: number, last: number, maxLength: number}} where   last: inclusive
 * @returns {{first: number, last: number}}
 */
export function rangeAround({ frame, span, first, last, maxLength }) {
  let from = Math.max(first, (span?.first ?? frame - maxLength / 2 + MARGIN) - MARGIN);
  let to = Math.min(last, (span?.last ?? frame + maxLength / 2 - 1 - MARGIN) + MARGIN);
  if (to - from + 1 > maxLength) {
    const centre = Math.min(Math.max(frame, from), to);
    from = Math.max(from, Math.min(centre - Math.floor(maxLength / 2), to - maxLength + 1));
    to = from + maxLength - 1;
  }
  return { first: Math.floor(from), last: Math.floor(to) };
}

/**
 * The reason for the initial range.
 *
 * @param {string|null} track    name of the selected track; null: none
 * @param {boolean} isWholeRun   the frames are those of the whole run
 */
export function describeRange(track, isWholeRun) {
  if (isWholeRun)
    return track === null
      ? 'All frames of the run.'
      : `All frames of the run: the selected track ${track} with ${MARGIN} frames around it needs all of them.`;
  return track === null
    ? 'Around the frame on screen; select a track first to get the frames around it.'
    : `Around the selected track ${track}.`;
}

/**
 * @param {import('../../state-types.js').ReviewState|null} review
 * @param {{id: string, initialLength: number, maxLength: number, onChange: (error: string) => void}} options   initialLength: maximum length of the initial range, frames; maxLength: of any range
 */
export function createFrameRange(review, { id, initialLength, maxLength, onChange }) {
  const run = review?.run;
  const first = run?.first ?? 0;
  const last = Math.max(first, first + (run?.frames_done ?? 1) - 1);
  const doc = review?.selected ? docOf(review, review.selected) : null;
  const span = doc && shownSpan(doc, review?.tracks);
  const initial = rangeAround({ frame: review?.frame ?? 0, span, first, last, maxLength: initialLength });
  const firstInput = numberInput(`${id}-first`, String(initial.first), validate, { inputmode: 'numeric' });
  const lastInput = numberInput(`${id}-last`, String(initial.last), validate, { inputmode: 'numeric' });
  const length = h('span.muted.small.export-count', { role: 'status' });

  /** @returns {{first: number, stop: number}|{error: string}} */
  function value() {
    const range = parseFrames(firstInput.value, lastInput.value, { low: first, high: last });
    if ('error' in range) return range;
    const frames = range.stop - range.first;
    return frames > maxLength ? { error: `${plural(frames, 'frame')} are too many; at most ${maxLength} are allowed.` } : range;
  }

  function validate() {
    const found = value();
    setText(length, 'error' in found ? '' : plural(found.stop - found.first, 'frame'));
    onChange('error' in found ? found.error : '');
  }

  const isWholeRun = initial.first === first && initial.last === last;
  const element = h(
    'div.stack',
    h('div.export-pair', field('First frame', firstInput), field('Last frame', lastInput)),
    h(
      'p.row',
      h('span.field-hint.grow', describeRange(doc && review?.selected ? trackName(review.selected, doc) : null, isWholeRun)),
      length,
    ),
  );
  return { element, value, validate, focus: firstInput };
}
