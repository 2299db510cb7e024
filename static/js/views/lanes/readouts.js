// @ts-check
/** Readouts of the lanes at one frame: playhead, time, values beside each lane, votes, flipped verdicts. */

import { lastIndexAt } from '../../model/detail_columns.js';
import { count, percent, plural } from '../../model/format.js';
import { countFlips } from '../../model/gate_lane.js';
import { engineName } from '../../model/labels.js';
import { shortNumber } from '../../model/describe_events.js';
import { SUB_LANES } from '../../model/sub_lanes.js';
import { timeLabel, toFrame, toX } from '../../model/time_axis.js';
import { setAttribute, setText } from '../dom.js';
import { fillLegend } from './layout.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

/**
 * The time of a frame from the video's frame table, else from its rate while the table is loading.
 *
 * @param {ReviewState} review
 * @param {number} frame
 * @returns {number} s from the first frame
 */
export function secondsAt(review, frame) {
  if (review.timebase !== null) return review.timebase.secondsAt(frame);
  const { rate, frames, duration } = review.video;
  return frame / (rate ?? (frames && duration ? frames / duration : 25));
}

/**
 * @param {import('./layout.js').LanesLayout} parts
 * @param {object} view
 * @param {ReviewState} view.review
 * @param {{first: number, last: number}} view.span
 * @param {number} view.frames
 * @param {number} view.width            width of the plots, px
 * @param {number} view.gutter           width to the left of the plots, px
 * @param {number|null} view.hovered     place of the pointer, px
 * @returns {number} the frame of the readouts: under the pointer, else at the cursor
 */
export function placeMarks(parts, { review, span, frames, width, gutter, hovered }) {
  const x = toX(span, review.frame + 0.5, width);
  parts.playhead.hidden = x < 0 || x > width;
  parts.playhead.style.setProperty('transform', `translateX(${Math.round(gutter + x)}px)`);
  parts.hover.hidden = hovered === null;
  if (hovered !== null) parts.hover.style.setProperty('transform', `translateX(${Math.round(gutter + hovered)}px)`);
  parts.window.style.setProperty('transform', `translateX(${(span.first / frames) * width}px)`);
  parts.window.style.setProperty('width', `${Math.max(4, ((span.last - span.first) / frames) * width)}px`);
  parts.overviewCursor.style.setProperty('transform', `translateX(${Math.round((review.frame / frames) * width)}px)`);
  const frame = hovered === null ? review.frame : Math.min(frames - 1, Math.floor(toFrame(span, Math.max(0, hovered), width)));
  setText(parts.readout, `${timeLabel(secondsAt(review, frame), 0.01)}  frame ${count(frame)}`);
  setAttribute(parts.axisPlot, 'aria-valuenow', review.frame);
  setAttribute(parts.axisPlot, 'aria-valuemin', 0);
  setAttribute(parts.axisPlot, 'aria-valuemax', frames - 1);
  setAttribute(parts.axisPlot, 'aria-valuetext', `frame ${review.frame}, ${timeLabel(secondsAt(review, review.frame), 0.01)}`);
  return frame;
}

/**
 * @param {import('./layout.js').LanesLayout} parts
 * @param {ReturnType<typeof import('./tau_slider.js').createTauSlider>} slider
 * @param {object} view
 * @param {ReviewState} view.review
 * @param {number} view.frame
 * @param {import('../../model/detail_columns.js').DetailColumns|null} view.columns   null: no track with values is selected
 * @param {import('../../types.js').TrackLane|null} view.lane
 * @param {import('../../state-types.js').State['labels']} view.labels
 * @param {import('./palette.js').Palette} view.palette
 */
export function showValues(parts, slider, { review, frame, columns, lane, labels, palette }) {
  parts.reset.hidden = review.tau === null;
  setText(parts.whatIf.children[1], review.tau === null ? 'What if tau = …' : `What if tau = ${shortNumber(review.tau)}`);
  if (columns === null || lane === null) return;
  const nearest = lastIndexAt(columns.frame, frame);
  const column = nearest >= 0 && columns.frame[nearest] === frame ? nearest : -1;
  SUB_LANES.forEach((sub, i) => {
    let text = sub.series.map((name) => (column < 0 ? '–' : shortNumber(columns?.series[name][column]))).join(' / ');
    if (sub.kind === 'votes') text = '';
    if (sub.id === 'svm' && column >= 0 && lane?.probability[column] !== null) text += ` (P ${shortNumber(lane?.probability[column])})`;
    setText(parts.values[i], text);
  });
  const votes = column >= 0 ? lane.votes[column] : null;
  fillLegend(
    parts.legend,
    lane.classes.slice(0, 4).map((id, c) => ({
      name: engineName(labels, id, lane?.words?.[c]),
      share: votes ? percent(votes[c]) : '–',
      colour: palette.series[c],
    })),
  );
  const { unit } = palette;
  const tau = review.tau ?? lane.tau;
  const flips = countFlips(lane, tau);
  setText(parts.flips, flips.total > 0 ? `${flips.total} of ${plural(flips.verdicts, 'verdict')} flip` : plural(flips.verdicts, 'verdict'));
  parts.flips.classList.toggle('lanes-flipping', flips.total > 0);
  slider.update({
    tau,
    domain: columns.domain,
    top: 4 * unit,
    height: SUB_LANES[0].height * unit - 8 * unit,
    dragged: review.tau !== null,
    flips,
  });
}
