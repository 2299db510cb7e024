// @ts-check
/** Describes people's corrections of a track, as a whole and in a frame. Pure. */

import { keyFramesOf, lastKey, keyFrameBoxAt } from './documents.js';
import { listNames } from './track_name.js';

/**
 * @param {import('../types.js').TrackDoc} doc
 * @param {number} frame
 * @returns {string|null} null: none, the engine's result applies
 */
export function describeCorrectionAt(doc, frame) {
  const keyFrame = lastKey(doc, frame);
  if (keyFrame === null) return null;
  const state = doc.keys[keyFrame];
  if (state.outside) return `A person marked it as outside${keyFrame === frame ? '' : ` from frame ${keyFrame} on`}.`;
  const hidden = state.occluded ? ['A person marked it as partly hidden.'] : [];
  if (keyFrameBoxAt(doc, frame) === null) return hidden[0] ?? null;
  if (keyFrame === frame && state.box !== null) return ['A person put the box here.', ...hidden].join(' ');
  const boxes = keyFramesOf(doc).filter((key) => doc.keys[key].box !== null);
  const [before, after] = [boxes.filter((key) => key <= frame).at(-1), boxes.find((key) => key > frame)];
  return [`The box is interpolated between a person’s boxes in frames ${before} and ${after}.`, ...hidden].join(' ');
}

/** Maximum number of frames to name. */
const MAX_NAMED_FRAMES = 3;

/**
 * Describes people's labels: of the whole track, and of single boxes, which the track's title does not show.
 * @param {import('../types.js').TrackDoc|undefined} doc
 * @param {number|null} engine   the engine's class; null: none
 * @param {(id: number) => string} nameOf
 * @param {string|null} [word]   the engine's name for it, if the set has no label for it
 * @returns {string|null} null: no label by a person
 */
export function describeLabels(doc, engine, nameOf, word = null) {
  if (!doc) return null;
  const sentences = [];
  if (doc.class_id !== null) {
    const other =
      engine === null
        ? ''
        : engine === doc.class_id && word === null
          ? '; the engine reads the same'
          : `; the engine reads ${word ?? nameOf(engine)}`;
    sentences.push(`Label set by a person${other}.`);
  }
  const boxLabels = keyFramesOf(doc).flatMap((frame) => {
    const { class_id } = doc.keys[frame];
    return class_id === null || class_id === (doc.class_id ?? engine) ? [] : [`${nameOf(class_id)} in frame ${frame}`];
  });
  if (boxLabels.length) sentences.push(`Single boxes have other labels: ${listNames(boxLabels, MAX_NAMED_FRAMES)}.`);
  return sentences.length ? sentences.join(' ') : null;
}
