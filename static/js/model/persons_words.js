// @ts-check
/** What people have said about a track, and about it in a frame, in plain sentences. Pure. */

import { keyFramesOf, lastKey, lineAt } from './documents.js';

/**
 * @param {import('../types.js').TrackDoc} doc
 * @param {number} frame
 * @returns {string|null} null: nothing, what the engine has stands
 */
export function personAt(doc, frame) {
  const held = lastKey(doc, frame);
  if (held === null) return null;
  const state = doc.keys[held];
  if (state.outside) return `A person says that it is outside${held === frame ? '' : ` since frame ${held}`}.`;
  const hidden = state.occluded ? ['A person says that it is partly hidden.'] : [];
  if (lineAt(doc, frame) === null) return hidden[0] ?? null;
  if (held === frame && state.box !== null) return ['A person put the box here.', ...hidden].join(' ');
  const boxes = keyFramesOf(doc).filter((key) => doc.keys[key].box !== null);
  const [before, after] = [boxes.filter((key) => key <= frame).at(-1), boxes.find((key) => key > frame)];
  return [`The box lies on the line between a person’s boxes in frames ${before} and ${after}.`, ...hidden].join(' ');
}

/** Frames that are named. */
const NAMED = 3;

/**
 * What people have said about its class: of the whole track, and of single boxes, which the track's title does not show.
 * @param {import('../types.js').TrackDoc|undefined} doc
 * @param {number|null} engine   the engine's class of it; null: none
 * @param {(id: number) => string} nameOf
 * @param {string|null} [word]   what the engine calls it, where the set lacks that
 * @returns {string|null} null: nothing
 */
export function whoseLabel(doc, engine, nameOf, word = null) {
  if (!doc) return null;
  const words = [];
  if (doc.class_id !== null) {
    const other =
      engine === null
        ? ''
        : engine === doc.class_id && word === null
          ? '; the engine says the same'
          : `; the engine says ${word ?? nameOf(engine)}`;
    words.push(`Label set by a person${other}.`);
  }
  const own = keyFramesOf(doc).flatMap((frame) => {
    const { class_id } = doc.keys[frame];
    return class_id === null || class_id === (doc.class_id ?? engine) ? [] : [`${nameOf(class_id)} in frame ${frame}`];
  });
  const more = own.length > NAMED ? ` and ${own.length - NAMED} more` : '';
  if (own.length) words.push(`Single boxes are called otherwise: ${own.slice(0, NAMED).join(', ')}${more}.`);
  return words.length ? words.join(' ') : null;
}
