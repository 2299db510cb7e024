// @ts-check
/**
 * Labels and attributes of a whole track replace those of single frames. The twin of app/edits/relabel.py; pure.
 *
 * @typedef {import('../types.js').Attributes} Attributes
 * @typedef {import('../types.js').AttributeValue} AttributeValue
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { keyFramesOf, sameState, stateOf, withAttributes, withKey } from './documents.js';

/**
 * A label for the whole track applies to every box: labels of single boxes are removed, and with them key frames
 * without other content.
 * @param {TrackDoc} doc
 * @param {number|null} class_id   null: the engine's
 * @returns {TrackDoc}
 */
export function relabelTrack(doc, class_id) {
  const keys = reduceKeyFrames(doc, (key) => ({ ...key, class_id: null }));
  return { ...doc, class_id, keys };
}

/**
 * The document with another value of an attribute.
 * @param {TrackDoc} doc
 * @param {string} name
 * @param {AttributeValue|null} value   null: removes its own value
 * @param {number|null} frame   null: the whole track; else from this frame on, up to the next change of the value
 * @returns {TrackDoc}
 */
export function withAttribute(doc, name, value, frame) {
  if (frame === null) {
    const keys = reduceKeyFrames(doc, (key) => withAttributes(key, withValue(key.attributes, name, null)));
    return withAttributes({ ...doc, keys }, withValue(doc.attributes, name, value));
  }
  doc = withKey(doc, frame, {});
  const keys = { ...doc.keys };
  const old = valueOf(keys[frame].attributes, name);
  for (const key of keyFramesOf(doc)) {
    if (key < frame) continue;
    if (valueOf(keys[key].attributes, name) !== old) break;
    keys[key] = withAttributes(keys[key], withValue(keys[key].attributes, name, value));
  }
  return { ...doc, keys };
}

/**
 * Key frames after a reduction of each, without those that have no other content.
 * @param {TrackDoc} doc
 * @param {(key: KeyFrame) => KeyFrame} reduce
 */
function reduceKeyFrames(doc, reduce) {
  /** @type {Record<string, KeyFrame>} */
  const keys = {};
  let state = stateOf();
  let stateBefore = state;
  for (const frame of keyFramesOf(doc)) {
    const before = doc.keys[frame];
    const key = reduce(before);
    if (changesState(key, state) || !changesState(before, stateBefore)) {
      keys[frame] = key;
      state = stateOf(key);
    }
    stateBefore = stateOf(before);
  }
  return keys;
}

/**
 * Whether a key frame changes the state that already holds.
 * @param {KeyFrame} key
 * @param {ReturnType<typeof stateOf>} held
 */
const changesState = (key, held) => key.box !== null || key.class_id !== null || !sameState(stateOf(key), held);

/** @param {Attributes|undefined} attributes @param {string} name @returns {AttributeValue|undefined} */
const valueOf = (attributes, name) => (attributes && Object.hasOwn(attributes, name) ? attributes[name] : undefined);

/**
 * @param {Attributes|undefined} attributes
 * @param {string} name
 * @param {AttributeValue|null} value
 * @returns {Attributes}
 */
function withValue(attributes, name, value) {
  const others = Object.entries(attributes ?? {}).filter(([key]) => key !== name);
  return Object.fromEntries(value === null ? others : [...others, [name, value]]);
}
