// @ts-check
/**
 * Lists of operations on their way to the server. Pure.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 */
import { CommandError, applyCommand, touchedKeys } from '../model/commands.js';
import { docOf, docsFor } from './revisions.js';

/**
 * @param {Pending['command']} command
 * @returns {Command|null} null: an undo or redo, which only the server can carry out
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
 * The revisions that a person saw when they made an edit: what it is checked against, however late it is sent.
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
 * Documents with everything on its way applied. What no longer makes sense is left out: the server will say so.
 * @param {ReviewState} review
 * @param {Record<string, TrackDoc>} confirmed
 * @param {readonly Pick<Pending, 'command'|'author'>[]} pending   in order
 * @param {string} time                  for notes, ISO 8601
 * @returns {Record<string, TrackDoc>}
 */
export function projected(review, confirmed, pending, time) {
  let docs = confirmed;
  for (const { command, author } of pending) {
    const own = asCommand(command);
    if (own === null) continue;
    try {
      docs = applyCommand({ ...docsFor({ ...review, docs }, own), ...docs }, own, { author, time }).docs;
    } catch (thrown) {
      if (!(thrown instanceof CommandError)) throw thrown;
    }
  }
  return docs;
}

/**
 * After one of our own operations was stored, those behind it build on what it left.
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
    const moved = { ...one, seen: { ...one.seen, ...Object.fromEntries(touched.map(({ key, revision }) => [key, revision])) } };
    changed.push(moved);
    return moved;
  });
  return { pending: next, changed };
}

/**
 * A verdict on many tracks without some of them; null: none is left. What is no such verdict stays as it is.
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
  return { ...pending, command: { ...own, key, others }, seen: Object.fromEntries(Object.entries(pending.seen).filter(([one]) => !keys.includes(one))) };
}

/**
 * An operation that was refused, and those behind it that build on it.
 * @param {readonly Pending[]} pending
 * @param {Pending} refused
 * @returns {{held: Pending[], left: Pending[]}}
 */
export function parted(pending, refused) {
  const keys = new Set(keysOf(refused));
  /** @type {Pending[]} */
  const held = [];
  const left = pending.filter((one) => {
    const bound = one.op_id === refused.op_id || keysOf(one).some((key) => keys.has(key));
    if (bound) {
      for (const key of keysOf(one)) keys.add(key);
      held.push(one);
    }
    return !bound;
  });
  return { held, left };
}
