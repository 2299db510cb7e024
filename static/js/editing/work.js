// @ts-check
/**
 * What the parts of the editor share: the open run's documents as the server has them, and what is on its way to it.
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

/** Operations whose undo can be shown before the server has answered it; those before them wait for it. */
const REMEMBERED = 200;

/**
 * @param {import('../state-types.js').Store} store
 * @param {import('./outbox.js').Outbox} outbox
 */
export function createWork(store, outbox) {
  const fresh = () => ({
    ready: false,
    /** More has come, or may have, since the documents were asked for. */
    overtaken: false,
    /** What the server has acknowledged. @type {Record<string, TrackDoc>} */
    confirmed: {},
    /** @type {Pending[]} */
    pending: [],
    /** Made before the documents have come: shown on what the engine said, checked and sent when they have. @type {Early[]} */
    early: [],
    /** Refused because somebody else was first; kept in the outbox until a person decides. @type {Pending[]} */
    held: [],
    /** What can be taken back and brought back of what the server has. */
    line: UNASKED,
    /** What this page's operations that are stored did. @type {Map<string, import('./pending.js').Step>} */
    steps: new Map(),
    /** Those that the server has of this page. @type {Set<string>} */
    stored: new Set(),
  });

  const work = {
    /** @type {string|null} */
    run: null,
    ...fresh(),

    /** @param {string|null} run   that is open now */
    begin(run) {
      Object.assign(work, fresh(), { run });
    },

    /** What is next for an undo or redo, with everything that is on its way. @param {'undo'|'redo'} what */
    next: (what) => nextOf(after(work.line, [...work.pending, ...work.early]), what),

    /** Documents as they are with everything that is on its way. */
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

    /** The server has it. @param {Pending} done @param {readonly TrackDoc[]} docs   as it left them */
    remember(done, docs) {
      const { op_id, command } = done;
      work.stored.add(op_id);
      work.line = after(work.line, [done]);
      // answered once more, it says nothing of what was before
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

    /** The same operation otherwise, to be sent in its place. @param {Pending} moved */
    replace(moved) {
      work.pending = work.pending.map((one) => (one.op_id === moved.op_id ? moved : one));
      work.keep(moved);
    },

    /** The server will never have it, nor what takes it back. @param {Pending} given */
    forget(given) {
      const gone = givenUp(work.pending, given);
      work.pending = work.pending.filter((one) => !gone.some(({ op_id }) => op_id === one.op_id));
      for (const { op_id } of gone) outbox.remove(op_id).catch(() => {});
    },
  };
  return work;
}
