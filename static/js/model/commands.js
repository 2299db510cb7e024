// @ts-check
/**
 * What each command does to the documents. The twin of app/edits/apply.py: both give the same on the golden cases in
 * tests/golden/edits. Pure: nothing that comes in is changed.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').Segment} Segment
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{author: string, time: string}} Person   for notes; time in ISO 8601
 */
import {
  OPEN_END, beganAs, blankDoc, emptyDoc, isEmpty, keyFramesOf, lastKey, lineAt, said, sameAttributes, showsFrom, stateOf, withKey,
} from './documents.js';
import { join } from './join.js';
import { relabelled, withAttribute } from './relabel.js';

/** A command that makes no sense for the documents; the message is one sentence. */
export class CommandError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = 'CommandError';
  }
}

/**
 * Keys of the tracks that a command reads or changes.
 * @param {Command} command
 * @returns {string[]}
 */
export function touchedKeys(command) {
  const made = command.name === 'split' && command.new_key ? [command.new_key] : [];
  return [...new Set([command.key, ...(command.others ?? []), ...made])];
}

/**
 * All documents after a command; revisions stay, the server raises them.
 * @param {Record<string, TrackDoc>} docs   by key; engine tracks without one are taken from `command.spans`
 * @param {Command} command
 * @param {Person} person
 * @returns {{docs: Record<string, TrackDoc>, changed: string[]}}
 * @throws {CommandError} there is no such track, it is gone, or there is nothing to do it to
 */
export function applyCommand(docs, command, person) {
  /** @type {Record<string, TrackDoc>} */
  const known = {};
  for (const span of command.spans ?? []) known[`m${span.track}`] = emptyDoc(span);
  const changed = change({ ...known, ...docs }, command, person);
  return { docs: { ...docs, ...changed }, changed: Object.keys(changed) };
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {Command} command
 * @param {Person} person
 * @returns {Record<string, TrackDoc>} the changed ones
 */
function change(docs, command, person) {
  if (command.name === 'create_track') return { [command.key]: create(docs, command) };
  if (command.name === 'restore_track') return { [command.key]: restore(present(docs, command.key)) };
  const doc = alive(docs, command.key);
  if (command.name === 'review_tracks') {
    const review = needed(command.review, 'review');
    return Object.fromEntries(touchedKeys(command).map((key) => [key, { ...alive(docs, key), review }]));
  }
  if (command.name === 'merge') return merge(docs, doc, command);
  if (command.name === 'split') return split(docs, doc, command);
  return { [doc.key]: alone(doc, command, person) };
}

/** @param {Record<string, TrackDoc>} docs @param {string} key @returns {TrackDoc} */
function present(docs, key) {
  const doc = docs[key];
  if (!doc) throw new CommandError(`There is no track ${key}.`);
  return doc;
}

/** @param {Record<string, TrackDoc>} docs @param {string} key @returns {TrackDoc} */
function alive(docs, key) {
  const doc = present(docs, key);
  if (doc.gone) throw new CommandError(whyGone(doc));
  return doc;
}

/** @param {TrackDoc} doc */
function whyGone(doc) {
  if (doc.merged_into !== null) return `Track ${doc.key} was merged into track ${doc.merged_into}. Change that one, or undo the merge.`;
  return `Track ${doc.key} is deleted. Restore it first.`;
}

/**
 * @param {TrackDoc} doc
 * @returns {TrackDoc}
 */
function restore(doc) {
  if (!doc.gone) throw new CommandError(`Track ${doc.key} is not deleted.`);
  if (doc.merged_into !== null) throw new CommandError(whyGone(doc));
  if (isEmpty(doc)) throw new CommandError(`Nothing is left of track ${doc.key}: what made it was undone.`);
  return { ...doc, gone: false };
}

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 * @param {Person} person
 * @returns {TrackDoc}
 */
function alone(doc, command, person) {
  const { frame } = command;
  switch (command.name) {
    case 'set_box':
      return withKey(doc, frame, { box: needed(command.box, 'box'), outside: false, followed: false });
    case 'add_key':
      return withKey(doc, frame, { box: needed(command.box, 'box'), followed: false });
    case 'relabel_track':
      return relabelled(doc, command.class_id ?? null);
    case 'relabel_box':
      return withKey(doc, frame, { class_id: command.class_id ?? null, ...shown(doc, command) });
    case 'set_occluded':
      return withKey(doc, frame, { occluded: command.value === true, ...shown(doc, command) });
    case 'set_outside':
      return setOutside(doc, command);
    case 'set_not_a_sign':
      return { ...doc, not_a_sign: command.value === true };
    case 'ignore':
      return setIgnore(doc, command.value === true);
    case 'attribute':
      return setAttribute(doc, command);
    case 'set_review':
      return { ...doc, review: needed(command.review, 'review') };
    case 'delete_from':
      return deleteFrom(doc, frame);
    case 'delete_track':
      return { ...doc, gone: true };
    case 'remove_key':
      return removeKey(doc, frame);
    case 'interpolate':
      return interpolate(doc, command);
    case 'follow':
      return follow(doc, command);
    case 'add_note':
      return addNote(doc, command, person);
    case 'edit_note':
      requireNote(doc, command);
      return {
        ...doc,
        // words of somebody else never stand under the name of who wrote the note
        notes: doc.notes.map((n) => (n.id === command.note_id ? { ...n, text: needed(command.text, 'text'), ...(n.author !== person.author && person) } : n)),
      };
    case 'remove_note':
      requireNote(doc, command);
      return { ...doc, notes: doc.notes.filter((n) => n.id !== command.note_id) };
    default:
      throw new CommandError(`There is no command ${command.name}.`);
  }
}

/**
 * @template T
 * @param {T|null|undefined} value
 * @param {string} name
 * @returns {T}
 */
function needed(value, name) {
  if (value === null || value === undefined) throw new CommandError(`The command needs a ${name}.`);
  return value;
}

/**
 * The box that a key frame keeps: the one on screen, or the line's.
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Partial<KeyFrame>}
 */
function shown(doc, command) {
  const box = command.box ?? lineAt(doc, command.frame);
  return box === null ? {} : { box };
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {Command} command
 * @returns {TrackDoc}
 */
function create(docs, command) {
  const { key, frame } = command;
  if (docs[key]) throw new CommandError(`There is a track ${key} already.`);
  if (!key.startsWith('h')) throw new CommandError('A new track has a key that starts with h.');
  const first = { box: needed(command.box, 'box'), occluded: false, outside: false, interpolate: true, class_id: null, followed: false };
  return { ...blankDoc(key), class_id: command.class_id ?? null, keys: { [frame]: first } };
}

/**
 * @param {TrackDoc} doc
 * @param {boolean} ignore
 * @returns {TrackDoc}
 */
function setIgnore(doc, ignore) {
  const { ignore: _before, ...others } = doc;
  return { ...others, ...said({ ignore }) };
}

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {TrackDoc}
 */
function setAttribute(doc, command) {
  const name = needed(command.attribute, 'name of an attribute');
  if (!command.from_here) return withAttribute(doc, name, command.value ?? null, null);
  return withAttribute(withKey(doc, command.frame, shown(doc, command)), name, command.value ?? null, command.frame);
}

/**
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {TrackDoc}
 */
function deleteFrom(doc, frame) {
  if (!showsFrom(doc, frame)) throw new CommandError(`${showsNothing(doc, frame)} There is nothing to delete.`);
  // a line that is cut must end where it was when it was cut
  const edge = frame > 0 ? lineAt(doc, frame - 1) : null;
  if (edge !== null && !doc.keys[frame - 1]) doc = withKey(doc, frame - 1, { box: edge });
  const kept = { ...doc, segments: clip(doc.segments, -1, frame - 1), keys: keysWithin(doc, -1, frame - 1) };
  return isEmpty(kept) ? { ...doc, gone: true } : kept;
}

/** @param {TrackDoc} doc @param {number} frame */
const showsNothing = (doc, frame) => `Track ${doc.key} shows nothing from frame ${frame} on.`;

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {TrackDoc}
 */
function setOutside(doc, command) {
  const { frame } = command;
  const outside = command.value === true;
  if (outside && !showsFrom(doc, frame)) throw new CommandError(`${showsNothing(doc, frame)} It is outside already.`);
  const after = withKey(doc, frame, { outside, ...shown(doc, command) });
  if (!outside && !showsFrom(after, frame)) {
    throw new CommandError(`${showsNothing(doc, frame)} Nothing could come back into sight: draw a box.`);
  }
  return after;
}

/**
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {TrackDoc}
 */
function removeKey(doc, frame) {
  if (!doc.keys[frame]) throw new CommandError(`Frame ${frame} is no key frame of track ${doc.key}.`);
  const { [frame]: _gone, ...keys } = doc.keys;
  const left = { ...doc, keys };
  if (isEmpty(left)) throw new CommandError("This is the track's only box. Delete the track instead.");
  return left;
}

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {TrackDoc}
 */
function interpolate(doc, command) {
  const first = needed(command.first, 'first');
  const last = needed(command.last, 'last');
  const inside = keyFramesOf(doc).filter((k) => first <= k && k <= last);
  if (inside.filter((k) => doc.keys[k].box !== null).length < 2) {
    throw new CommandError('Interpolation needs two key frames with a box. Correct the box in two frames first.');
  }
  const keys = { ...doc.keys };
  for (const k of inside.slice(0, -1)) keys[k] = { ...keys[k], interpolate: command.value !== false };
  return { ...doc, keys };
}

/**
 * Key frames at the given boxes, on lines; those that were followed before make room, a person's stay.
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {TrackDoc}
 */
function follow(doc, command) {
  const given = needed(command.boxes, 'list of boxes');
  const boxes = new Map(given.map((entry) => [entry.frame, entry]));
  const first = needed(given[0]?.frame, 'box');
  const last = needed(given.at(-1)?.frame, 'box');
  const frames = keyFramesOf(doc);
  const hides = frames.find((k, at) => k <= last && doc.keys[k].outside && (frames[at + 1] ?? Infinity) > first);
  if (hides !== undefined) {
    throw new CommandError(`Track ${doc.key} is outside from frame ${hides} on, as a person says. Follow up to there, or bring it back first.`);
  }
  /** @param {number} k */
  const inside = (k) => first <= k && k <= last;
  const changes = frames.filter((k, at) => !sameAttributes(doc.keys[k].attributes, doc.keys[frames[at - 1]]?.attributes));
  const after = lastKey(doc, last);
  const lineGoesOn = after === null ? doc.segments.length === 0 : doc.keys[after].interpolate;
  /** @type {Record<string, KeyFrame>} */
  const keys = Object.fromEntries(Object.entries(doc.keys).filter(([k, key]) => !(inside(Number(k)) && key.followed)));
  for (const frame of new Set([...boxes.keys(), ...[...changes, ...Object.keys(keys).map(Number)].filter(inside)])) {
    const held = lastKey(doc, frame);
    const { occluded, attributes } = stateOf(held === null ? null : doc.keys[held]);
    const fresh = { box: null, occluded, outside: false, interpolate: false, class_id: null, followed: false, ...said({ attributes }) };
    const own = keys[frame] ?? fresh;
    const entry = boxes.get(frame);
    const placed = entry ? { box: entry.box, followed: !entry.anchor } : {};
    keys[frame] = { ...own, ...placed, interpolate: frame < last || lineGoesOn };
  }
  return { ...doc, keys };
}

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 * @param {Person} person
 * @returns {TrackDoc}
 */
function addNote(doc, command, person) {
  const id = needed(command.note_id, 'note_id');
  if (doc.notes.some((n) => n.id === id)) throw new CommandError('There is a note of that name already.');
  const note = { id, frame: command.frame, text: needed(command.text, 'text'), ...person };
  return { ...doc, notes: [...doc.notes, note] };
}

/**
 * @param {TrackDoc} doc
 * @param {Command} command
 */
function requireNote(doc, command) {
  if (!doc.notes.some((n) => n.id === command.note_id)) {
    throw new CommandError('There is no such note (any more).');
  }
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Record<string, TrackDoc>}
 */
function merge(docs, doc, command) {
  /** @type {Record<string, TrackDoc>} */
  const changed = {};
  for (const key of new Set(command.others ?? [])) {
    const other = docs[key];
    if (!other || other.gone || key === doc.key) {
      throw new CommandError(`Track ${key} cannot be merged: it is gone, or the same track.`);
    }
    doc = join(doc, other);
    changed[key] = { ...other, gone: true, merged_into: doc.key };
  }
  return { [doc.key]: doc, ...changed };
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {TrackDoc} doc
 * @param {Command} command
 * @returns {Record<string, TrackDoc>}
 */
function split(docs, doc, command) {
  const { frame } = command;
  const made = needed(command.new_key, 'new_key');
  if (docs[made]) throw new CommandError(`There is a track ${made} already.`);
  const before = frame > 0 ? lineAt(doc, frame - 1) : null;
  const at = lineAt(doc, frame);
  if (at !== null && !doc.keys[frame]) doc = withKey(doc, frame, { box: at });
  if (before !== null && !doc.keys[frame - 1]) doc = withKey(doc, frame - 1, { box: before });
  const later = keysWithin(doc, frame, Infinity);
  const carried = lastKey(doc, frame);
  if (carried !== null && carried < frame) {
    const state = stateOf(doc.keys[carried]);
    if (state.occluded || state.outside || state.attributes) {
      later[frame] = { box: null, class_id: null, followed: false, ...state, interpolate: false };
    }
  }
  /** @type {TrackDoc} */
  const fresh = {
    ...blankDoc(made),
    class_id: doc.class_id,
    not_a_sign: doc.not_a_sign,
    ...said(doc),
    segments: clip(doc.segments, frame, OPEN_END),
    keys: later,
    notes: doc.notes.filter((n) => n.frame >= frame),
  };
  const old = {
    ...doc,
    segments: clip(doc.segments, -1, frame - 1),
    keys: keysWithin(doc, -1, frame - 1),
    notes: doc.notes.filter((n) => n.frame < frame),
  };
  if (isEmpty(old) || isEmpty(fresh)) {
    throw new CommandError(`Track ${doc.key} has nothing on one side of frame ${frame}. Split it in between.`);
  }
  const class_id = command.class_id ?? null;
  return { [old.key]: withClass(old, class_id), [fresh.key]: withClass(fresh, class_id) };
}

/**
 * The document with the class that it showed, where it has lost all that the engine's label comes with.
 * @param {TrackDoc} doc
 * @param {number|null} class_id
 * @returns {TrackDoc}
 */
function withClass(doc, class_id) {
  return doc.class_id !== null || beganAs(doc) !== null ? doc : { ...doc, class_id };
}

/**
 * @param {TrackDoc} doc
 * @param {number} first
 * @param {number} last
 * @returns {Record<string, KeyFrame>}
 */
function keysWithin(doc, first, last) {
  return Object.fromEntries(Object.entries(doc.keys).filter(([k]) => first <= Number(k) && Number(k) <= last));
}

/**
 * What lies within first to last, both included.
 * @param {Segment[]} segments
 * @param {number} first
 * @param {number} last
 * @returns {Segment[]}
 */
function clip(segments, first, last) {
  return segments
    .map((s) => ({ track: s.track, first: Math.max(s.first, first), last: Math.min(s.last, last) }))
    .filter((s) => s.first <= s.last);
}
