// @ts-check
/**
 * The state that the editor's modules share: the open run's documents as the server has them, and the operations on
 * their way to it.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {Pick<Pending, 'op_id'|'author'|'command'|'about'>} EarlyEdit
 * @typedef {ReturnType<typeof createEditorState>} EditorState
 */
import { showBanner } from '../store/actions/page.js';
import { changeReview } from '../store/actions/review.js';
import { UNKNOWN_HISTORY, afterOperations, nextTarget } from './undo_history.js';
import { asCommand, withCounterparts, applyPending, createStep } from './pending.js';

/**
 * Number of operations whose undo is shown before the server answers. The undo of an older one waits for the answer.
 */
const MAX_KNOWN_STEPS = 200;

/** @param {import('../state-types.js').Store} store @param {import('./outbox.js').Outbox} outbox */
export function createEditorState(store, outbox) {
  const initial = () => ({
    ready: false,
    /** Events have, or may have, arrived since the documents were requested. */
    isOutdated: false,
    /** Documents that the server has acknowledged. @type {Record<string, TrackDoc>} */
    confirmed: {},
    /** @type {Pending[]} */
    pending: [],
    /** Made before the documents arrived: shown on the engine's tracks; checked and sent after the arrival. @type {EarlyEdit[]} */
    early: [],
    /** Refused because another person changed the track first; in the outbox until the user decides. @type {Pending[]} */
    held: [],
    /** The operations on the server that can be undone and redone. */
    history: UNKNOWN_HISTORY,
    /** The effects of this page's stored operations. @type {Map<string, import('./pending.js').Step>} */
    steps: new Map(),
    /** Ids of this page's operations that the server has stored. @type {Set<string>} */
    stored: new Set(),
  });

  const edits = {
    /** @type {string|null} */
    run: null,
    ...initial(),

    /** @param {string|null} run   the run that is now open */
    reset(run) {
      Object.assign(edits, initial(), { run });
    },

    /** The target of the next undo or redo, including operations on their way. @param {'undo'|'redo'} what */
    nextTarget: (what) => nextTarget(afterOperations(edits.history, [...edits.pending, ...edits.early]), what),

    /** Show the documents with all operations on their way applied. */
    show() {
      const { review } = store.get();
      if (review === null || edits.run === null) return;
      const docs = applyPending(review, edits.confirmed, [...edits.pending, ...edits.early], new Date().toISOString(), edits.steps);
      /** @param {boolean} held @returns {(one: EarlyEdit) => {op_id: string, command: Command, held: boolean}} */
      const entry =
        (held) =>
        ({ op_id, command }) => ({ op_id, command: /** @type {Command} */ (command), held });
      const unsaved = [...edits.held.map(entry(true)), ...edits.pending.map(entry(false)), ...edits.early.map(entry(false))];
      store.dispatch(changeReview, { docs, unsaved, undo: edits.nextTarget('undo'), redo: edits.nextTarget('redo') });
    },

    /** @param {readonly TrackDoc[]} docs */
    confirm(docs) {
      for (const doc of docs) {
        if ((edits.confirmed[doc.key]?.revision ?? -1) <= doc.revision) edits.confirmed = { ...edits.confirmed, [doc.key]: doc };
      }
    },

    /** Remember an operation that the server has stored. @param {Pending} operation @param {readonly TrackDoc[]} docs   as the operation left them */
    recordStored(operation, docs) {
      const { op_id, command } = operation;
      edits.stored.add(op_id);
      edits.history = afterOperations(edits.history, [operation]);
      // the answer to a repeated operation does not say what was before it
      const first = docs.every(({ key, revision }) => (edits.confirmed[key]?.revision ?? 0) < revision);
      if (asCommand(command) === null || !first) return;
      edits.steps.set(op_id, createStep(edits.confirmed, docs));
      for (const old of edits.steps.keys()) if (edits.steps.size > MAX_KNOWN_STEPS) edits.steps.delete(old);
    },

    /** @param {Pending} operation */
    save(operation) {
      outbox.put(operation).catch(() => {
        store.dispatch(showBanner, {
          id: 'outbox',
          tone: 'warning',
          text: 'This browser cannot keep unsaved work (a private window, or a page of an older version beside this one?). Wait for "All saved" before you close the page.',
        });
      });
    },

    /** Replace an operation by a changed version of it. @param {Pending} changed */
    replace(changed) {
      edits.pending = edits.pending.map((one) => (one.op_id === changed.op_id ? changed : one));
      edits.save(changed);
    },

    /** Forget an operation that the server will never store, and its undo. @param {Pending} operation */
    forget(operation) {
      const forgotten = withCounterparts(edits.pending, operation);
      edits.pending = edits.pending.filter((one) => !forgotten.some(({ op_id }) => op_id === one.op_id));
      for (const { op_id } of forgotten) outbox.remove(op_id).catch(() => {});
    },
  };
  return edits;
}
