// @ts-check
/** Pictures of the frames in which two versions of a track differ, with both boxes. */

import { differences, regionAround } from '../../model/version_differences.js';
import { h, s } from '../dom.js';
import { count } from '../../model/format.js';

/** @typedef {import('../../types.js').TrackDoc} TrackDoc */
/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

/**
 * @param {Pick<import('../../page-types.js').App, 'api'>} app
 * @param {ReviewState|null} review
 * @param {TrackDoc|undefined} saved
 * @param {TrackDoc|undefined} mine
 * @returns {HTMLElement|null}   null: no known box differs
 */
export function twoVersions(app, review, saved, mine) {
  const video = review?.video;
  if (!review || !video?.width || !video.height) return null;
  /** @param {number} track @param {number} frame */
  const engineBox = (track, frame) => review.overlays[frame]?.tracks.find(({ id }) => id === track)?.box ?? null;
  const found = differences(saved, mine, engineBox, review.frame);
  if (found.length === 0) return null;
  return h(
    'div.stack',
    h(
      'div.row.two-versions',
      ...found.map(({ frame, saved: theirs, mine: own }) => {
        const both = /** @type {const} */ ([
          { box: theirs, whose: 'saved' },
          { box: own, whose: 'mine' },
        ]);
        return partOfFrame(
          app,
          video,
          frame,
          both,
          `Frame ${count(frame)} with ${theirs && own ? 'both boxes' : theirs ? 'the saved box' : 'the box with your change'}`,
          `Frame ${count(frame)}`,
        );
      }),
    ),
    h(
      'p.row.small.two-versions-legend',
      h('span.two-versions-key.two-versions-key-saved'),
      'saved',
      h('span.two-versions-key.two-versions-key-mine'),
      'with your change',
    ),
  );
}

/**
 * The part of a frame around boxes.
 * @param {Pick<import('../../page-types.js').App, 'api'>} app
 * @param {import('../../types.js').Video} video
 * @param {number} frame
 * @param {readonly {box: import('../../types.js').Box|null, whose: 'saved'|'mine'}[]} boxes   null: not known, so not drawn
 * @param {string} words       description of the picture
 * @param {string} [caption]   default: `words`
 */
export function partOfFrame(app, video, frame, boxes, words, caption = words) {
  const [width, height] = [video.width ?? 1, video.height ?? 1];
  const known = boxes.flatMap(({ box }) => (box === null ? [] : [box]));
  const part = known.length ? regionAround(known, width, height) : { x: 0, y: 0, width, height };
  return h(
    'figure.two-versions-frame',
    s(
      'svg.two-versions-picture',
      { viewBox: `${part.x} ${part.y} ${part.width} ${part.height}`, role: 'img', 'aria-label': words },
      s('image', { href: app.api.frameUrl(video.id, frame), width, height, preserveAspectRatio: 'none' }),
      ...boxes.flatMap(({ box, whose }) => rectangles(box, whose)),
    ),
    h('figcaption.muted.small', caption),
  );
}

/** @param {import('../../types.js').Box|null} box @param {'saved'|'mine'} whose */
function rectangles(box, whose) {
  if (box === null) return [];
  const [x, y, right, bottom] = box;
  return ['casing', whose].map((kind) =>
    s('rect', { class: `two-versions-box two-versions-${kind}`, x, y, width: right - x, height: bottom - y }),
  );
}
