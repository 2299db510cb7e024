// @ts-check
/**
 * Commands on the key frames of one track. Pure. The twin of a part of app/edits/apply.py.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { CommandError, requireValue } from './command_error.js';
import {
  clipSegments,
  isEmpty,
  keyAt,
  keyFramesOf,
  keysWithin,
  keyFrameBoxAt,
  newKeyFrame,
  sameAttributes,
  showsFrom,
  stateOf,
  withKey,
} from './documents.js';
import { withAttribute } from './relabel.js';

/**
 * The box of a new key frame: the box on screen, else the interpolated one.
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Partial<KeyFrame>}
 */
export function visibleBox(doc, command) {
  const box = command.box ?? keyFrameBoxAt(doc, command.frame);
  return box === null ? {} : { box };
}

/** @param {TrackDoc} doc @param {Command} command @returns {TrackDoc} */
export function setAttribute(doc, command) {
  const name = requireValue(command.attribute, 'name of an attribute');
  if (!command.from_here) return withAttribute(doc, name, command.value ?? null, null);
  return withAttribute(withKey(doc, command.frame, visibleBox(doc, command)), name, command.value ?? null, command.frame);
}

/** @param {TrackDoc} doc @param {number} frame @returns {TrackDoc} */
export function deleteFrom(doc, frame) {
  if (!showsFrom(doc, frame)) throw new CommandError(`${showsNothing(doc, frame)} There is nothing to delete.`);
  doc = withLineEnds(doc, frame);
  const cutDoc = { ...doc, segments: clipSegments(doc.segments, -1, frame - 1), keys: keysWithin(doc, -1, frame - 1) };
  return isEmpty(cutDoc) ? { ...doc, gone: true } : cutDoc;
}

/**
 * The same track with boxes where the line across a cut before a frame starts and ends, so that each half keeps its
 * part. The line has gaps where key frames without a box are not interpolated.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {TrackDoc}
 */
export function withLineEnds(doc, frame) {
  const frames = keyFramesOf(doc);
  const start = frames.findLast((k) => k < frame && doc.keys[k].box !== null) ?? Infinity;
  const end = frames.find((k) => k >= frame && doc.keys[k].box !== null) ?? -1;
  const changes = frames.filter((k) => start < k && k < end && (keyFrameBoxAt(doc, k - 1) === null) !== (keyFrameBoxAt(doc, k) === null));
  let pinned = doc;
  for (const edge of [frame, ...changes].flatMap((k) => [k - 1, k])) {
    const box = keyFrameBoxAt(doc, edge);
    if (box !== null && !pinned.keys[edge]?.box) pinned = withKey(pinned, edge, { box });
  }
  return pinned;
}

/** @param {TrackDoc} doc @param {number} frame */
const showsNothing = (doc, frame) => `Track ${doc.key} shows nothing from frame ${frame} on.`;

/** @param {TrackDoc} doc @param {Command} command @returns {TrackDoc} */
export function setOutside(doc, command) {
  const { frame } = command;
  const outside = command.value === true;
  if (outside && !showsFrom(doc, frame)) throw new CommandError(`${showsNothing(doc, frame)} It is outside already.`);
  const after = withKey(doc, frame, { outside, ...visibleBox(doc, command) });
  if (!outside && !showsFrom(after, frame)) {
    throw new CommandError(`${showsNothing(doc, frame)} Nothing could come back into view: draw a box.`);
  }
  return after;
}

/** @param {TrackDoc} doc @param {number} frame @returns {TrackDoc} */
export function removeKey(doc, frame) {
  if (!doc.keys[frame]) throw new CommandError(`Frame ${frame} is no key frame of track ${doc.key}.`);
  const { [frame]: _gone, ...keys } = doc.keys;
  const remaining = { ...doc, keys };
  if (isEmpty(remaining)) throw new CommandError("This is the track's only box. Delete the track instead.");
  return remaining;
}

/** @param {TrackDoc} doc @param {Command} command @returns {TrackDoc} */
export function interpolate(doc, command) {
  const first = requireValue(command.first, 'first');
  const last = requireValue(command.last, 'last');
  const inside = keyFramesOf(doc).filter((k) => first <= k && k <= last);
  if (inside.filter((k) => doc.keys[k].box !== null).length < 2) {
    throw new CommandError('Interpolation needs two key frames with a box. Correct the box in two frames first.');
  }
  const keys = { ...doc.keys };
  for (const k of inside.slice(0, -1)) keys[k] = { ...keys[k], interpolate: command.value !== false };
  return { ...doc, keys };
}

/**
 * Set interpolated key frames at the given boxes. They replace key frames of earlier follows, but not a person's.
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {TrackDoc}
 */
export function follow(doc, command) {
  const given = requireValue(command.boxes, 'list of boxes');
  const boxes = new Map(given.map((entry) => [entry.frame, entry]));
  const first = requireValue(given[0]?.frame, 'box');
  const last = requireValue(given.at(-1)?.frame, 'box');
  const frames = keyFramesOf(doc);
  const hides = frames.find((k, at) => k <= last && doc.keys[k].outside && (frames[at + 1] ?? Infinity) > first);
  if (hides !== undefined) {
    throw new CommandError(
      `Track ${doc.key} is outside from frame ${hides} on, as a person says. Follow up to there, or bring it back first.`,
    );
  }
  /** @param {number} k */
  const inside = (k) => first <= k && k <= last;
  const changes = frames.filter((k, at) => !sameAttributes(doc.keys[k].attributes, doc.keys[frames[at - 1]]?.attributes));
  const isInterpolatedAfter = keyAt(doc, last)?.interpolate ?? doc.segments.length === 0;
  /** @type {Record<string, KeyFrame>} */
  const keys = Object.fromEntries(Object.entries(doc.keys).filter(([k, key]) => !(inside(Number(k)) && key.followed)));
  for (const frame of new Set([...boxes.keys(), ...[...changes, ...Object.keys(keys).map(Number)].filter(inside)])) {
    const keyFrame = keys[frame] ?? newKeyFrame({ ...stateOf(keyAt(doc, frame)), outside: false });
    const entry = boxes.get(frame);
    const placed = entry ? { box: entry.box, followed: !entry.anchor } : {};
    keys[frame] = { ...keyFrame, ...placed, interpolate: frame < last || isInterpolatedAfter };
  }
  return { ...doc, keys };
}
