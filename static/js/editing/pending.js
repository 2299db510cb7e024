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
  const own = asCommand(command);
  return own === null ? [] : touchedKeys(own);
}

/**
 * The revisions that a person saw when they made an edit. The server checks the edit against these, however late it is
 * sent.
 * @param {ReviewState} review
 * @param {Record<string, TrackDoc>} confirmed   documents as the server has them
 * @param {Pending['command']} command
 * @returns {Record<string, number>}
 */
export function revisionsSeen(review, confirmed, command) {
  const own = asCommand(command);
  /** @type {Record<string, number>} */
  const seen = {};
  for (const key of own === null ? [] : touchedKeys(own)) {
    const doc = confirmed[key] ?? docOf({ ...review, docs: confirmed }, key);
    if (doc) seen[key] = doc.revision;
    else if (own?.key === key && own.name !== 'create_track') seen[key] = 0;
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
export function projected(review, confirmed, pending, time, stored = new Map()) {
  let docs = confirmed;
  /** @type {Map<string, Step>} */
  const steps = new Map();
  for (const { op_id, command, author } of pending) {
    const own = asCommand(command);
    if (own === null) {
      const { op_id: of, name } = /** @type {{name: 'undo'|'redo', op_id: string}} */ (command);
      const step = steps.get(of) ?? stored.get(of);
      if (step) docs = { ...docs, ...reverted(review, docs, name === 'undo' ? step.before : step.after) };
      continue;
    }
    try {
      const made = applyCommand({ ...docsFor({ ...review, docs }, own), ...docs }, own, { author, time });
      steps.set(
        op_id,
        stepTo(
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
export const stepTo = (docs, changed) => ({
  before: Object.fromEntries(changed.map(({ key }) => [key, docs[key] ?? null])),
  after: Object.fromEntries(changed.map((doc) => [doc.key, doc])),
});

/** @param {ReviewState} review @param {Record<string, TrackDoc>} docs @param {Record<string, TrackDoc|null>} goal @returns {Record<string, TrackDoc>} */
function reverted(review, docs, goal) {
  return Object.fromEntries(
    Object.entries(goal).map(([key, doc]) => {
      // without a document: the engine's track; of a track that a person made, nothing is left
      const wanted = doc ?? docOf({ ...review, docs: {} }, key) ?? { ...blankDoc(key), gone: true };
      return [key, { ...wanted, revision: docs[key]?.revision ?? 0 }];
    }),
  );
}

/**
 * Operations rebased onto the revisions that one of our own stored operations produced.
 * @param {readonly Pending[]} pending
 * @param {readonly TrackDoc[]} stored
 * @returns {{pending: Pending[], changed: Pending[]}}
 */
export function rebased(pending, stored) {
  /** @type {Pending[]} */
  const changed = [];
  const next = pending.map((one) => {
    const touched = stored.filter(({ key }) => keysOf(one).includes(key));
    if (touched.length === 0) return one;
    const moved = {
      ...one,
      seen: { ...one.seen, ...Object.fromEntries(touched.map(({ key, revision }) => [key, Math.max(one.seen[key] ?? 0, revision)])) },
    };
    changed.push(moved);
    return moved;
  });
  return { pending: next, changed };
}

/**
 * A verdict on several tracks without some of them; null: none is left. Other operations stay unchanged.
 * @param {Pending} pending
 * @param {readonly string[]} keys
 * @returns {Pending|null}
 */
export function without(pending, keys) {
  const own = asCommand(pending.command);
  const all = keysOf(pending);
  const left = all.filter((one) => !keys.includes(one));
  if (own?.name !== 'review_tracks' || left.length === all.length) return pending;
  const [key, ...others] = left;
  if (key === undefined) return null;
  return {
    ...pending,
    command: { ...own, key, others },
    seen: Object.fromEntries(Object.entries(pending.seen).filter(([one]) => !keys.includes(one))),
  };
}

/**
 * Splits off a refused operation, the later ones that build on it, and their undos.
 * @param {readonly Pending[]} pending
 * @param {Pending} refused
 * @returns {{held: Pending[], left: Pending[]}}
 */
export function parted(pending, refused) {
  const keys = new Set(keysOf(refused));
  /** @type {Pending[]} */
  const held = [];
  const left = pending.filter((one) => {
    const bound = one.op_id === refused.op_id || keysOf(one).some((key) => keys.has(key)) || held.some((other) => isAbout(one, other));
    if (bound) {
      for (const key of keysOf(one)) keys.add(key);
      held.push(one);
    }
    return !bound;
  });
  return { held, left };
}

/** Whether an undo or redo is about an operation. @param {Pick<Pending, 'command'>} one @param {Pick<Pending, 'op_id'>} other */
const isAbout = (one, { op_id }) => asCommand(one.command) === null && Reflect.get(one.command, 'op_id') === op_id;

/**
 * The edits that remain in the end: without those that a later undo takes back.
 * @param {readonly Pending[]} pending   in order
 */
export function standing(pending) {
  return pending.filter(
    (one) => asCommand(one.command) !== null && pending.findLast((other) => isAbout(other, one))?.command.name !== 'undo',
  );
}

/**
 * Operations to give up with one that the server will never store: for an edit its undo; for an undo or redo its
 * counterpart and all that continue from it.
 * @template {Pick<Pending, 'op_id'|'command'>} T
 * @param {readonly T[]} pending
 * @param {T} given
 * @returns {T[]} includes the operation itself
 */
export function givenUp(pending, given) {
  const of = asCommand(given.command) === null ? Reflect.get(given.command, 'op_id') : given.op_id;
  const at = pending.findIndex(({ op_id }) => op_id === given.op_id);
  return [
    given,
    ...pending.slice(at + 1).filter((one) => isAbout(one, { op_id: of }) || (of !== given.op_id && isAbout(one, { op_id: '' }))),
  ];
}
