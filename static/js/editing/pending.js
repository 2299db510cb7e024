// @ts-check
/**
 * Lists of operations on their way to the server. Pure functions.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 */
import { CommandError, applyCommand, touchedKeys } from '../model/commands.js';
import { blankDoc } from '../model/documents.js';
import { docOf, docsFor } from './revisions.js';

/**
 * @param {Pending['command']} command
 * @returns {Command|null} null: an undo or redo, which only the server can perform
 */
export function asCommand(command) {
  return command.name === 'undo' || command.name === 'redo' ? null : /** @type {Command} */ (command);
}

/** @param {Pending} pending @returns {string[]} tracks that it touches */
export function keysOf({ command }) {
  const edit = asCommand(command);
  return edit === null ? [] : touchedKeys(edit);
}

/**
 * The revisions that a person saw when they made an edit. The server checks the edit against these, however late it is
 * sent.
 * @param {ReviewState} review
 * @param {Record<string, TrackDoc>} confirmed   documents as the server has them
 * @param {Pending['command']} command
 * @returns {Record<string, number>}
 */
export function seenRevisions(review, confirmed, command) {
  const edit = asCommand(command);
  /** @type {Record<string, number>} */
  const seen = {};
  for (const key of edit === null ? [] : touchedKeys(edit)) {
    const doc = confirmed[key] ?? docOf({ ...review, docs: confirmed }, key);
    if (doc) seen[key] = doc.revision;
    else if (edit?.key === key && edit.name !== 'create_track') seen[key] = 0;
  }
  return seen;
}

/**
 * Tracks before and after an operation; null: the track had no document.
 * @typedef {{before: Record<string, TrackDoc|null>, after: Record<string, TrackDoc>}} Step
 */

/**
 * Documents with all operations on their way applied. Commands that are no longer possible are omitted, because the
 * server will refuse them; so is an undo of an operation that this page has not seen.
 * @param {ReviewState} review
 * @param {Record<string, TrackDoc>} confirmed
 * @param {readonly Pick<Pending, 'op_id'|'command'|'author'>[]} pending   in order
 * @param {string} time                  for notes, ISO 8601
 * @param {ReadonlyMap<string, Step>} [stored]   effects of operations that the server has stored, by op_id
 * @returns {Record<string, TrackDoc>}
 */
export function applyPending(review, confirmed, pending, time, stored = new Map()) {
  let docs = confirmed;
  /** @type {Map<string, Step>} */
  const steps = new Map();
  for (const { op_id, command, author } of pending) {
    const edit = asCommand(command);
    if (edit === null) {
      const { op_id: target, name } = /** @type {{name: 'undo'|'redo', op_id: string}} */ (command);
      const step = steps.get(target) ?? stored.get(target);
      if (step) docs = { ...docs, ...restoredDocs(review, docs, name === 'undo' ? step.before : step.after) };
      continue;
    }
    try {
      const made = applyCommand({ ...docsFor({ ...review, docs }, edit), ...docs }, edit, { author, time });
      steps.set(
        op_id,
        createStep(
          docs,
          made.changed.map((key) => made.docs[key]),
        ),
      );
      docs = made.docs;
    } catch (thrown) {
      if (!(thrown instanceof CommandError)) throw thrown;
    }
  }
  return docs;
}

/** @param {Record<string, TrackDoc>} docs @param {readonly TrackDoc[]} changed @returns {Step} */
export const createStep = (docs, changed) => ({
  before: Object.fromEntries(changed.map(({ key }) => [key, docs[key] ?? null])),
  after: Object.fromEntries(changed.map((doc) => [doc.key, doc])),
});

/** @param {ReviewState} review @param {Record<string, TrackDoc>} docs @param {Record<string, TrackDoc|null>} goal @returns {Record<string, TrackDoc>} */
function restoredDocs(review, docs, goal) {
  return Object.fromEntries(
    Object.entries(goal).map(([key, doc]) => {
      // without a document: the engine's track; of a track that a person made, nothing is left
      const restored = doc ?? docOf({ ...review, docs: {} }, key) ?? { ...blankDoc(key), gone: true };
      return [key, { ...restored, revision: docs[key]?.revision ?? 0 }];
    }),
  );
}

/**
 * Operations rebased onto the revisions that one of our own stored operations produced.
 * @param {readonly Pending[]} pending
 * @param {readonly TrackDoc[]} stored
 * @returns {{pending: Pending[], changed: Pending[]}}
 */
export function rebase(pending, stored) {
  /** @type {Pending[]} */
  const changed = [];
  const next = pending.map((one) => {
    const touched = stored.filter(({ key }) => keysOf(one).includes(key));
    if (touched.length === 0) return one;
    const rebased = {
      ...one,
      seen: { ...one.seen, ...Object.fromEntries(touched.map(({ key, revision }) => [key, Math.max(one.seen[key] ?? 0, revision)])) },
    };
    changed.push(rebased);
    return rebased;
  });
  return { pending: next, changed };
}

/**
 * A verdict on several tracks without some of them; null: none is left. Other operations stay unchanged.
 * @param {Pending} pending
 * @param {readonly string[]} keys
 * @returns {Pending|null}
 */
export function withoutTracks(pending, keys) {
  const edit = asCommand(pending.command);
  const all = keysOf(pending);
  const left = all.filter((one) => !keys.includes(one));
  if (edit?.name !== 'review_tracks' || left.length === all.length) return pending;
  const [key, ...others] = left;
  if (key === undefined) return null;
  return {
    ...pending,
    command: { ...edit, key, others },
    seen: Object.fromEntries(Object.entries(pending.seen).filter(([one]) => !keys.includes(one))),
  };
}

/**
 * Splits off a refused operation, the later ones that build on it, and their undos.
 * @param {readonly Pending[]} pending
 * @param {Pending} refused
 * @returns {{held: Pending[], left: Pending[]}}
 */
export function splitOffDependents(pending, refused) {
  const keys = new Set(keysOf(refused));
  /** @type {Pending[]} */
  const held = [];
  const left = pending.filter((one) => {
    const isDependent =
      one.op_id === refused.op_id || keysOf(one).some((key) => keys.has(key)) || held.some((other) => isAbout(one, other));
    if (isDependent) {
      for (const key of keysOf(one)) keys.add(key);
      held.push(one);
    }
    return !isDependent;
  });
  return { held, left };
}

/** Whether an undo or redo is about an operation. @param {Pick<Pending, 'command'>} one @param {Pick<Pending, 'op_id'>} other */
const isAbout = (one, { op_id }) => asCommand(one.command) === null && Reflect.get(one.command, 'op_id') === op_id;

/**
 * The edits that remain in the end: without those that a later undo takes back.
 * @param {readonly Pending[]} pending   in order
 */
export function withoutUndone(pending) {
  return pending.filter(
    (one) => asCommand(one.command) !== null && pending.findLast((other) => isAbout(other, one))?.command.name !== 'undo',
  );
}

/**
 * Operations to give up with one that the server will never store: for an edit its undo; for an undo or redo its
 * counterpart and all that continue from it.
 * @template {Pick<Pending, 'op_id'|'command'>} T
 * @param {readonly T[]} pending
 * @param {T} operation
 * @returns {T[]} includes the operation itself
 */
export function withCounterparts(pending, operation) {
  const target = asCommand(operation.command) === null ? Reflect.get(operation.command, 'op_id') : operation.op_id;
  const index = pending.findIndex(({ op_id }) => op_id === operation.op_id);
  return [
    operation,
    ...pending
      .slice(index + 1)
      .filter((one) => isAbout(one, { op_id: target }) || (target !== operation.op_id && isAbout(one, { op_id: '' }))),
  ];
}
