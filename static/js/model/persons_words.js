// @ts-check
/** Describes people's corrections of a track, as a whole and in a frame. Pure. */

import { keyFramesOf, lastKey, lineAt } from './documents.js';

/**
 * @param {import('../types.js').TrackDoc} doc
 * @param {number} frame
 * @returns {string|null} null: none, the engine's result applies
 */
export function personAt(doc, frame) {
  const held = lastKey(doc, frame);
  if (held === null) return null;
  const state = doc.keys[held];
  if (state.outside) return `A person marked it as outside${held === frame ? '' : ` from frame ${held} on`}.`;
  const hidden = state.occluded ? ['A person marked it as partly hidden.'] : [];
  if (lineAt(doc, frame) === null) return hidden[0] ?? null;
  if (held === frame && state.box !== null) return ['A person put the box here.', ...hidden].join(' ');
  const boxes = keyFramesOf(doc).filter((key) => doc.keys[key].box !== null);
  const [before, after] = [boxes.filter((key) => key <= frame).at(-1), boxes.find((key) => key > frame)];
  return [`The box is interpolated between a person’s boxes in frames ${before} and ${after}.`, ...hidden].join(' ');
}

/** Maximum number of frames to name. */
const NAMED = 3;

/**
 * Describes people's labels: of the whole track, and of single boxes, which the track's title does not show.
 * @param {import('../types.js').TrackDoc|undefined} doc
 * @param {number|null} engine   the engine's class; null: none
 * @param {(id: number) => string} nameOf
 * @param {string|null} [word]   the engine's name for it, if the set has no label for it
 * @returns {string|null} null: no label by a person
 */
export function whoseLabel(doc, engine, nameOf, word = null) {
  if (!doc) return null;
  const words = [];
  if (doc.class_id !== null) {
    const other =
      engine === null
        ? ''
        : engine === doc.class_id && word === null
          ? '; the engine reads the same'
          : `; the engine reads ${word ?? nameOf(engine)}`;
    words.push(`Label set by a person${other}.`);
  }
  const own = keyFramesOf(doc).flatMap((frame) => {
    const { class_id } = doc.keys[frame];
    return class_id === null || class_id === (doc.class_id ?? engine) ? [] : [`${nameOf(class_id)} in frame ${frame}`];
  });
  const more = own.length > NAMED ? ` and ${own.length - NAMED} more` : '';
  if (own.length) words.push(`Single boxes have other labels: ${own.slice(0, NAMED).join(', ')}${more}.`);
  return words.length ? words.join(' ') : null;
}
