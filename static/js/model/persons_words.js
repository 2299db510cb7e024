// @ts-check
/** What people have said about a track in a frame, in plain sentences. Pure. */

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
  if (state.outside) return `A person says that it is out of sight${held === frame ? '' : ` since frame ${held}`}.`;
  const hidden = state.occluded ? ['A person says that it is partly hidden.'] : [];
  if (lineAt(doc, frame) === null) return hidden[0] ?? null;
  if (held === frame && state.box !== null) return ['A person put the box here.', ...hidden].join(' ');
  const boxes = keyFramesOf(doc).filter((key) => doc.keys[key].box !== null);
  const [before, after] = [boxes.filter((key) => key <= frame).at(-1), boxes.find((key) => key > frame)];
  return [`The box lies on the line between a person’s boxes in frames ${before} and ${after}.`, ...hidden].join(' ');
}
