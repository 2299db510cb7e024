// @ts-check
/**
 * The state that the editor's modules share: the open run's documents as the server has them, and the operations on
 * their way to it.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {Pick<Pending, 'op_id'|'author'|'command'|'about'>} Early
 * @typedef {ReturnType<typeof createWork>} Work
 */
import { showBanner } from '../store/actions/page.js';
import { changeReview } from '../store/actions/review.js';
import { UNASKED, after, nextOf } from './line.js';
import { asCommand, givenUp, projected, stepTo } from './pending.js';

/**
 * Number of operations whose undo is shown before the server answers. The undo of an older one waits for the answer.
 */
const REMEMBERED = 200;

/**
 * @param {import('../state-types.js').Store} store
 * @param {import('./outbox.js').Outbox} outbox
 */
export function createWork(store, outbox) {
  const fresh = () => ({
    ready: false,
    /** Events have, or may have, arrived since the documents were requested. */
    overtaken: false,
    /** Documents that the server has acknowledged. @type {Record<string, TrackDoc>} */
    confirmed: {},
    /** @type {Pending[]} */
    pending: [],
    /** Made before the documents arrived: shown on the engine's tracks; checked and sent after the arrival. @type {Early[]} */
    early: [],
    /** Refused because another person changed the track first; in the outbox until the user decides. @type {Pending[]} */
    held: [],
    /** The operations on the server that can be undone and redone. */
    line: UNASKED,
    /** The effects of this page's stored operations. @type {Map<string, import('./pending.js').Step>} */
    steps: new Map(),
    /** Ids of this page's operations that the server has stored. @type {Set<string>} */
    stored: new Set(),
  });

  const work = {
    /** @type {string|null} */
    run: null,
    ...fresh(),

    /** @param {string|null} run   the run that is now open */
    begin(run) {
      Object.assign(work, fresh(), { run });
    },

    /** The target of the next undo or redo, including operations on their way. @param {'undo'|'redo'} what */
    next: (what) => nextOf(after(work.line, [...work.pending, ...work.early]), what),

    /** Show the documents with all operations on their way applied. */
    show() {
      const { review } = store.get();
      if (review === null || work.run === null) return;
      const docs = projected(review, work.confirmed, [...work.pending, ...work.early], new Date().toISOString(), work.steps);
      /** @param {boolean} held @returns {(one: Early) => {op_id: string, command: Command, held: boolean}} */
      const entry =
        (held) =>
        ({ op_id, command }) => ({ op_id, command: /** @type {Command} */ (command), held });
      const unsaved = [...work.held.map(entry(true)), ...work.pending.map(entry(false)), ...work.early.map(entry(false))];
      store.dispatch(changeReview, { docs, unsaved, undo: work.next('undo'), redo: work.next('redo') });
    },

    /** @param {readonly TrackDoc[]} docs */
    confirm(docs) {
      for (const doc of docs) {
        if ((work.confirmed[doc.key]?.revision ?? -1) <= doc.revision) work.confirmed = { ...work.confirmed, [doc.key]: doc };
      }
    },

    /** Remember an operation that the server has stored. @param {Pending} done @param {readonly TrackDoc[]} docs   as the operation left them */
    remember(done, docs) {
      const { op_id, command } = done;
      work.stored.add(op_id);
      work.line = after(work.line, [done]);
      // the answer to a repeated operation does not say what was before it
      const first = docs.every(({ key, revision }) => (work.confirmed[key]?.revision ?? 0) < revision);
      if (asCommand(command) === null || !first) return;
      work.steps.set(op_id, stepTo(work.confirmed, docs));
      for (const old of work.steps.keys()) if (work.steps.size > REMEMBERED) work.steps.delete(old);
    },

    /** @param {Pending} made */
    keep(made) {
      outbox.put(made).catch(() => {
        store.dispatch(showBanner, {
          id: 'outbox',
          tone: 'warning',
          text: 'This browser cannot keep unsaved work (a private window, or a page of an older version beside this one?). Wait for "All saved" before you close the page.',
        });
      });
    },

    /** Replace an operation by a changed version of it. @param {Pending} moved */
    replace(moved) {
      work.pending = work.pending.map((one) => (one.op_id === moved.op_id ? moved : one));
      work.keep(moved);
    },

    /** Forget an operation that the server will never store, and its undo. @param {Pending} given */
    forget(given) {
      const gone = givenUp(work.pending, given);
      work.pending = work.pending.filter((one) => !gone.some(({ op_id }) => op_id === one.op_id));
      for (const { op_id } of gone) outbox.remove(op_id).catch(() => {});
    },
  };
  return work;
}
