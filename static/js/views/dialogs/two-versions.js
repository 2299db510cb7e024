// @ts-check
/** Pictures of the frames in which two versions of a track differ, with both boxes. */

import {differences, partAround} from '../../model/two_versions.js';
import {h, s} from '../dom.js';
import {count} from '../format.js';

/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

/**
 * @param {Pick<import('../../page-types.js').App, 'api'>} app
 * @param {ReviewState|null} review
 * @param {TrackDoc|undefined} saved
 * @param {TrackDoc|undefined} mine
 * @returns {HTMLElement|null}   null: they differ in no box that is known here
 */
export function twoVersions(app, review, saved, mine) {
  const video = review?.video;
  if (!review || !video?.width || !video.height) return null;
  const {width, height} = video;
  /** @param {number} track @param {number} frame */
  const engineBox = (track, frame) => review.overlays[frame]?.tracks.find(({id}) => id === track)?.box ?? null;
  const found = differences(saved, mine, engineBox, review.frame);
  if (found.length === 0) return null;
  return h('div', {class: 'stack'},
    h('div', {class: 'row two-versions'}, ...found.map(({frame, saved: theirs, mine: own}) => {
      const boxes = [theirs, own].filter((box) => box !== null);
      const part = partAround(boxes, width, height);
      return h('figure', {class: 'two-versions-frame'},
        s('svg', {class: 'two-versions-picture', viewBox: `${part.x} ${part.y} ${part.width} ${part.height}`, role: 'img', 'aria-label': `Frame ${count(frame)} with ${theirs && own ? 'both boxes' : theirs ? 'the saved box' : 'the box with your change'}`},
          s('image', {href: app.api.frameUrl(video.id, frame), width, height, preserveAspectRatio: 'none'}),
          ...rectangles(theirs, 'saved'), ...rectangles(own, 'mine')),
        h('figcaption', {class: 'muted small'}, `Frame ${count(frame)}`));
    })),
    h('p', {class: 'row small two-versions-legend'},
      h('span', {class: 'two-versions-key two-versions-key-saved'}), 'saved', h('span', {class: 'two-versions-key two-versions-key-mine'}), 'with your change'));
}

/** @param {import('../../types.js').Box|null} box @param {'saved'|'mine'} whose */
function rectangles(box, whose) {
  if (box === null) return [];
  const [x, y, right, bottom] = box;
  return ['casing', whose].map((kind) => s('rect', {class: `two-versions-box two-versions-${kind}`, x, y, width: right - x, height: bottom - y}));
}
