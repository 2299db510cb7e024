// @ts-check
/** The confidence of each proposed box of a follow, on the time axis of the lanes. */

import { acceptedSpan } from '../../model/following.js';
import { toX } from '../../model/time_axis.js';
import { h } from '../dom.js';
import { prepareCanvas } from './palette.js';

/** Boxes with a lower confidence have another colour. */
const LOW_CONFIDENCE = 0.5;

export function createFollowingStrip() {
  const canvas = h('canvas.lanes-canvas', { 'aria-hidden': 'true' });
  const plot = h('div.lanes-plot', { title: 'Confidence of each proposed box; cut-off frames are pale' }, canvas);
  const element = h('div.lanes-strip.lanes-following', { hidden: true }, h('div.lanes-gutter', h('span.small.muted', 'Proposal')), plot);
  return {
    element,
    plot,
    /**
     * @param {import('../../model/following.js').Following|null} following
     * @param {number} width    CSS px
     * @param {{first: number, last: number}} span   range of frames in the lanes
     * @param {import('./palette.js').Palette} palette
     */
    paint(following, width, span, palette) {
      element.hidden = following === null;
      if (following === null) return;
      const height = plot.clientHeight;
      const ctx = prepareCanvas(canvas, width, height, palette.ratio);
      if (!ctx) return;
      const accepted = acceptedSpan(following);
      const barWidth = Math.max(1, width / (span.last - span.first));
      for (const [name, { confidence }] of Object.entries(following.proposals)) {
        const frame = Number(name);
        const x = toX(span, frame, width);
        if (x + barWidth < 0 || x > width) continue;
        ctx.globalAlpha = accepted.first <= frame && frame <= accepted.last ? 1 : 0.3;
        ctx.fillStyle = confidence < LOW_CONFIDENCE ? palette.colour.bad : palette.colour.accent;
        const barHeight = Math.max(1, confidence * (height - 2));
        ctx.fillRect(x, height - barHeight, barWidth, barHeight);
      }
      ctx.globalAlpha = 1;
      ctx.fillStyle = palette.colour.lineStrong;
      for (const { frame } of following.anchors) ctx.fillRect(toX(span, frame + 0.5, width) - 1, 0, 2, height);
    },
  };
}
