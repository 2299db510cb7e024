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
 * @param {TrackDoc|undefined} savedDoc
 * @param {TrackDoc|undefined} ownDoc
 * @returns {HTMLElement|null}   null: no known box differs
 */
export function createVersionComparison(app, review, savedDoc, ownDoc) {
  const video = review?.video;
  if (!review || !video?.width || !video.height) return null;
  /** @param {number} track @param {number} frame */
  const engineBox = (track, frame) => review.overlays[frame]?.tracks.find(({ id }) => id === track)?.box ?? null;
  const differing = differences(savedDoc, ownDoc, engineBox, review.frame);
  if (differing.length === 0) return null;
  return h(
    'div.stack',
    h(
      'div.row.two-versions',
      ...differing.map(({ frame, saved: savedBox, mine: ownBox }) => {
        const boxes = /** @type {const} */ ([
          { box: savedBox, version: 'saved' },
          { box: ownBox, version: 'mine' },
        ]);
        return createFrameCrop(
          app,
          video,
          frame,
          boxes,
          `Frame ${count(frame)} with ${savedBox && ownBox ? 'both boxes' : savedBox ? 'the saved box' : 'the box with your change'}`,
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
 * @param {readonly {box: import('../../types.js').Box|null, version: 'saved'|'mine'}[]} boxes   null: not known, so not drawn
 * @param {string} description   description of the picture
 * @param {string} [caption]   default: `description`
 */
export function createFrameCrop(app, video, frame, boxes, description, caption = description) {
  const [width, height] = [video.width ?? 1, video.height ?? 1];
  const known = boxes.flatMap(({ box }) => (box === null ? [] : [box]));
  const crop = known.length ? regionAround(known, width, height) : { x: 0, y: 0, width, height };
  return h(
    'figure.two-versions-frame',
    s(
      'svg.two-versions-picture',
      { viewBox: `${crop.x} ${crop.y} ${crop.width} ${crop.height}`, role: 'img', 'aria-label': description },
      s('image', { href: app.api.frameUrl(video.id, frame), width, height, preserveAspectRatio: 'none' }),
      ...boxes.flatMap(({ box, version }) => rectangles(box, version)),
    ),
    h('figcaption.muted.small', caption),
  );
}

/** @param {import('../../types.js').Box|null} box @param {'saved'|'mine'} version */
function rectangles(box, version) {
  if (box === null) return [];
  const [x, y, right, bottom] = box;
  return ['casing', version].map((kind) =>
    s('rect', { class: `two-versions-box two-versions-${kind}`, x, y, width: right - x, height: bottom - y }),
  );
}
