// @ts-check
/**
 * The plan of "Keep mine": edits in conflict with another person's change, rewritten so that they apply on top of it.
 * Pure functions.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('../dialog-types.js').Plan} Plan
 * @typedef {import('../dialog-types.js').Last} Last
 */
import { CommandError, applyCommand } from '../model/commands.js';
import { asCommand, keysOf, withoutTracks } from './pending.js';
import { docOf, docsFor } from './revisions.js';

/**
 * Restores deleted tracks first. Redirects edits of a merged track to the track that it is part of.
 *
 * @param {ReviewState} review
 * @param {Record<string, TrackDoc>} confirmed   documents as the server has them
 * @param {readonly Pending[]} held              in order
 * @param {string} time                          for notes, ISO 8601
 * @returns {Plan}
 */
export function planKeepMine(review, confirmed, held, time) {
  let docs = confirmed;
  /** @type {Command[]} */
  const commands = [];
  /** @type {Map<string, string|null>} */
  const moved = new Map();
  /** @type {Plan['lost']} */
  const lost = [];
  /** Apply a command to the documents. @param {Command} command @param {string} author */
  const apply = (command, author) => {
    const made = applyCommand({ ...docsFor({ ...review, docs }, command), ...docs }, command, { author, time });
    docs = made.docs;
    commands.push(command);
  };
  for (const one of held) {
    // a verdict on several tracks restores none of them
    const operation = withoutTracks(
      one,
      keysOf(one).filter((key) => docs[key]?.gone),
    );
    const command = operation && asCommand(operation.command);
    if (!command) continue;
    const { author } = one;
    for (const key of [command.key, ...(command.others ?? [])]) {
      const into = mergedTrack(docs, key);
      if (into !== key) moved.set(key, into);
      else if (docs[key]?.gone) moved.set(key, null);
    }
    const redirected = redirect(docs, command);
    if (redirected === null) continue;
    const [before, count] = [docs, commands.length];
    try {
      for (const key of redirected.name === 'restore_track' ? [] : [redirected.key, ...(redirected.others ?? [])]) {
        if (docs[key]?.gone) apply({ name: 'restore_track', key, frame: redirected.frame }, author);
      }
      apply(redirected, author);
    } catch (thrown) {
      if (!(thrown instanceof CommandError)) throw thrown;
      // undo the restoration if the command is not possible
      docs = before;
      commands.length = count;
      lost.push({ name: command.name, why: thrown.message });
    }
  }
  const changed = Object.values(docs).filter((doc) => doc !== confirmed[doc.key]);
  return {
    commands,
    saved: changed.flatMap(({ key }) => docOf({ ...review, docs: confirmed }, key) ?? []),
    mine: changed,
    moved: [...moved].map(([key, into]) => ({ key, into })),
    lost,
  };
}

/** Whether the plan changes nothing, because both people made the same edits. @param {Plan} plan */
export function changesNothing({ saved, mine, lost }) {
  return (
    lost.length === 0 &&
    mine.every((doc) => {
      const other = saved.find(({ key }) => key === doc.key);
      return other !== undefined && isDeepEqual({ ...other, revision: 0 }, { ...doc, revision: 0 });
    })
  );
}

/** The track that a merged track is now part of. @param {Record<string, TrackDoc>} docs @param {string} key */
function mergedTrack(docs, key) {
  let at = key;
  for (let steps = 0; docs[at]?.merged_into && steps < 100; steps += 1) at = /** @type {string} */ (docs[at].merged_into);
  return at;
}

/**
 * The command, redirected to the tracks that its own are now part of; null: it is already done.
 * @param {Record<string, TrackDoc>} docs
 * @param {Command} command
 * @returns {Command|null}
 */
function redirect(docs, command) {
  const key = mergedTrack(docs, command.key);
  const gone = docs[key]?.gone ?? false;
  if (gone ? command.name === 'delete_track' : command.name === 'restore_track') return null;
  const { spans: _theirs, ...rest } = command;
  if (command.name !== 'merge') return { ...rest, key };
  const others = [...new Set((command.others ?? []).map((other) => mergedTrack(docs, other)))].filter((other) => other !== key);
  return others.length ? { ...rest, key, others } : null;
}

/**
 * Whether two JSON values are equal, regardless of the order of keys.
 * @param {unknown} a
 * @param {unknown} b
 * @returns {boolean}
 */
function isDeepEqual(a, b) {
  if (typeof a !== 'object' || typeof b !== 'object' || a === null || b === null) return a === b;
  const names = Object.keys(a);
  return (
    names.length === Object.keys(b).length && names.every((name) => name in b && isDeepEqual(Reflect.get(a, name), Reflect.get(b, name)))
  );
}
