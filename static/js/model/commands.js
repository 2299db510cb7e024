// @ts-check
/**
 * The effect of each command on the documents. The twin of app/edits/apply.py: both give the same results on the golden
 * cases in tests/golden/edits. Pure: the arguments are not changed.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').Segment} Segment
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{author: string, time: string}} Person   for notes; time in ISO 8601
 */
import { CommandError, requireValue } from './command_error.js';
import { blankDoc, emptyDoc, isEmpty, newKeyFrame, nonDefaultFields, stateOf, withKey } from './documents.js';
import { deleteFrom, follow, interpolate, removeKey, setAttribute, setOutside, visibleBox } from './key_commands.js';
import { relabelTrack } from './relabel.js';
import { merge, split } from './track_commands.js';

export { CommandError };

/** Keys of the tracks that a command reads or changes. @param {Command} command @returns {string[]} */
export function touchedKeys(command) {
  const newKeys = command.name === 'split' && command.new_key ? [command.new_key] : [];
  return [...new Set([command.key, ...(command.others ?? []), ...newKeys])];
}

/**
 * All documents after a command. Revisions stay the same; the server raises them.
 * @param {Record<string, TrackDoc>} docs   by key; engine tracks without one are taken from `command.spans`
 * @param {Command} command
 * @param {Person} person
 * @returns {{docs: Record<string, TrackDoc>, changed: string[]}}
 * @throws {CommandError} the track does not exist or is gone, or the command has nothing to act on
 */
export function applyCommand(docs, command, person) {
  /** @type {Record<string, TrackDoc>} */
  const engineDocs = {};
  for (const span of command.spans ?? []) engineDocs[`m${span.track}`] = emptyDoc(span);
  const changed = change({ ...engineDocs, ...docs }, command, person);
  return { docs: { ...docs, ...changed }, changed: Object.keys(changed) };
}

/**
 * @param {Record<string, TrackDoc>} docs
 * @param {Command} command
 * @param {Person} person
 * @returns {Record<string, TrackDoc>} the changed documents
 */
function change(docs, command, person) {
  if (command.name === 'create_track') return { [command.key]: create(docs, command) };
  if (command.name === 'restore_track') return { [command.key]: restore(requireDoc(docs, command.key)) };
  const doc = requireExisting(docs, command.key);
  if (command.name === 'review_tracks') {
    const review = requireValue(command.review, 'review');
    return Object.fromEntries(touchedKeys(command).map((key) => [key, { ...requireExisting(docs, key), review }]));
  }
  if (command.name === 'merge') return merge(docs, doc, command);
  if (command.name === 'split') return split(docs, doc, command);
  return { [doc.key]: changeTrack(doc, command, person) };
}

/** @param {Record<string, TrackDoc>} docs @param {string} key @returns {TrackDoc} */
function requireDoc(docs, key) {
  const doc = docs[key];
  if (!doc) throw new CommandError(`There is no track ${key}.`);
  return doc;
}

/** @param {Record<string, TrackDoc>} docs @param {string} key @returns {TrackDoc} */
function requireExisting(docs, key) {
  const doc = requireDoc(docs, key);
  if (doc.gone) throw new CommandError(whyGone(doc));
  return doc;
}

/** @param {TrackDoc} doc */
function whyGone(doc) {
  if (doc.merged_into !== null) return `Track ${doc.key} was merged into track ${doc.merged_into}. Change that one, or undo the merge.`;
  return `Track ${doc.key} is deleted. Restore it first.`;
}

/** @param {TrackDoc} doc @returns {TrackDoc} */
function restore(doc) {
  if (!doc.gone) throw new CommandError(`Track ${doc.key} is not deleted.`);
  if (doc.merged_into !== null) throw new CommandError(whyGone(doc));
  if (isEmpty(doc)) throw new CommandError(`Nothing is left of track ${doc.key}: what made it was undone.`);
  return { ...doc, gone: false };
}

/** @param {TrackDoc} doc @param {Command} command @param {Person} person @returns {TrackDoc} */
function changeTrack(doc, command, person) {
  const { frame } = command;
  switch (command.name) {
    case 'set_box':
      return withKey(doc, frame, { box: requireValue(command.box, 'box'), outside: false, followed: false });
    case 'add_key':
      return withKey(doc, frame, { box: requireValue(command.box, 'box'), followed: false });
    case 'relabel_track':
      return relabelTrack(doc, command.class_id ?? null);
    case 'relabel_box':
      return withKey(doc, frame, { class_id: command.class_id ?? null, ...visibleBox(doc, command) });
    case 'set_occluded':
      return withKey(doc, frame, { occluded: command.value === true, ...visibleBox(doc, command) });
    case 'set_outside':
      return setOutside(doc, command);
    case 'set_not_a_sign':
      return { ...doc, not_a_sign: command.value === true };
    case 'ignore':
      return setIgnore(doc, command.value === true);
    case 'attribute':
      return setAttribute(doc, command);
    case 'set_review':
      return { ...doc, review: requireValue(command.review, 'review') };
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
        // a text of another person must not stand under the name of the note's author
        notes: doc.notes.map((n) =>
          n.id === command.note_id ? { ...n, text: requireValue(command.text, 'text'), ...(n.author !== person.author && person) } : n,
        ),
      };
    case 'remove_note':
      requireNote(doc, command);
      return { ...doc, notes: doc.notes.filter((n) => n.id !== command.note_id) };
    default:
      throw new CommandError(`There is no command ${command.name}.`);
  }
}

/** @param {Record<string, TrackDoc>} docs @param {Command} command @returns {TrackDoc} */
function create(docs, command) {
  const { key, frame } = command;
  if (docs[key]) throw new CommandError(`There is a track ${key} already.`);
  if (!key.startsWith('h')) throw new CommandError('A new track has a key that starts with h.');
  const first = newKeyFrame({ ...stateOf(), interpolate: true }, requireValue(command.box, 'box'));
  return { ...blankDoc(key), class_id: command.class_id ?? null, keys: { [frame]: first } };
}

/** @param {TrackDoc} doc @param {boolean} ignore @returns {TrackDoc} */
function setIgnore(doc, ignore) {
  const { ignore: _before, ...others } = doc;
  return { ...others, ...nonDefaultFields({ ignore }) };
}

/** @param {TrackDoc} doc @param {Command} command @param {Person} person @returns {TrackDoc} */
function addNote(doc, command, person) {
  const id = requireValue(command.note_id, 'note_id');
  if (doc.notes.some((n) => n.id === id)) throw new CommandError('There is a note of that name already.');
  const note = { id, frame: command.frame, text: requireValue(command.text, 'text'), ...person };
  return { ...doc, notes: [...doc.notes, note] };
}

/** @param {TrackDoc} doc @param {Command} command */
function requireNote(doc, command) {
  if (!doc.notes.some((n) => n.id === command.note_id)) {
    throw new CommandError('There is no such note (any more).');
  }
}
