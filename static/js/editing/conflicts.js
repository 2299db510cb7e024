// @ts-check
/**
 * Edits that the server refuses because another person changed the track first: held until the user decides, or
 * resolved automatically.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 */
import { listed, trackName } from '../model/track_name.js';
import { hideBanner, openDialog, showBanner } from '../store/actions/page.js';
import { seek, select } from '../store/actions/review.js';
import { isAgreed, planned } from './keeping.js';
import { keysOf, parted, revisionsSeen, standing, without } from './pending.js';

/** Maximum number of tracks that a notice names. */
const NAMED = 5;

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {import('./outbox.js').Outbox} parts.outbox
 * @param {import('./work.js').Work} parts.work
 * @param {(text: string, options?: import('../core/toast.js').ToastOptions) => void} parts.toast
 * @param {(command: Command) => void} parts.enqueue
 * @param {() => Promise<void>} parts.refresh
 */
export function createConflicts({ store, outbox, work, toast, enqueue, refresh }) {
  /** Last change, and its author, of the tracks with held edits. @type {Record<string, import('./keeping.js').Last>} */
  let others = {};

  /**
   * @param {Pending} next                    the refused operation
   * @param {readonly TrackDoc[]} current     tracks in the other person's version
   * @param {typeof others} by                authors of the other changes
   */
  async function meet(next, current, by) {
    work.confirm(current);
    // undone before it was sent: there is no conflict
    if (!standing(work.pending).includes(next)) work.forget(next);
    else if (!leaveOut(next, current) && !putOnTop(next)) await hold(next, by);
  }

  /** Hold an operation and the later ones that build on it until the user decides. @param {Pending} next @param {typeof others} by */
  async function hold(next, by) {
    const { held, left } = parted(work.pending, next);
    const stand = standing(held);
    for (const one of held) if (!stand.includes(one)) outbox.remove(one.op_id).catch(() => {});
    work.pending = left;
    work.held = [...work.held, ...stand];
    others = { ...others, ...by };
    await refresh(); // includes the tracks that it was merged into
    decide();
  }

  /**
   * Leave the tracks that have changed out of a verdict on several tracks; the others get it.
   * @param {Pending} next
   * @param {readonly TrackDoc[]} current   the tracks that somebody else has changed
   */
  function leaveOut(next, current) {
    const less = without(
      next,
      current.map(({ key }) => key),
    );
    if (less === next) return false;
    if (less === null) work.forget(next);
    else work.replace(less);
    const names = listed(
      current.map(({ key }) => trackName(key, work.confirmed[key])),
      NAMED,
    );
    toast(`No verdict on ${current.length === 1 ? 'track' : 'tracks'} ${names}: changed by somebody else first.`, { stays: true });
    return true;
  }

  /** Repeat a note on top of the other change, which it cannot contradict. Not if other operations of ours build on it. @param {Pending} next */
  function putOnTop(next) {
    const review = store.get().review;
    const key = next.command.name === 'add_note' ? /** @type {Command} */ (next.command).key : null;
    if (review === null || key === null || work.confirmed[key]?.gone || work.pending.filter((one) => keysOf(one).includes(key)).length > 1)
      return false;
    work.replace({ ...next, seen: revisionsSeen(review, work.confirmed, next.command) });
    return true;
  }

  /** If the selected track no longer exists, select the track that it is part of. */
  function leaveGone() {
    const { selected, docs } = store.get().review ?? { selected: null, docs: {} };
    const doc = selected === null ? undefined : docs[selected];
    if (!doc?.gone) return null;
    store.dispatch(select, doc.merged_into);
    return doc;
  }

  /** Show both versions of what is held, and let a person choose. */
  function decide() {
    const review = store.get().review;
    const { held } = work;
    if (held.length === 0 || review === null) return;
    const plan = planned(review, work.confirmed, held, new Date().toISOString());
    /** @param {boolean} again */
    const settle = (again) => {
      const bound = work.held;
      work.held = [];
      others = {};
      store.dispatch(hideBanner, 'conflict');
      // changes that arrived since the dialog was opened count too
      const { commands } = again ? planned(store.get().review ?? review, work.confirmed, bound, '') : { commands: [] };
      for (const command of commands) enqueue(command);
      // only now: if the page closes before this point, it asks again and nothing is lost
      for (const one of bound) outbox.remove(one.op_id).catch(() => {});
      work.show();
      const last = commands.at(-1);
      // show the result, also if it went to another track
      if (last) store.dispatch((state) => select(seek(state, last.frame), last.key));
      leaveGone();
    };
    if (isAgreed(plan)) {
      settle(false);
      return;
    }
    const text = `${held.length === 1 ? 'A change is' : `${held.length} changes are`} not saved: somebody else changed the same track first.`;
    store.dispatch((state) =>
      openDialog(
        showBanner(state, {
          id: 'conflict',
          tone: 'warning',
          text,
          action: { label: 'Decide', operation: 'decide-conflict' },
        }),
        { kind: 'conflict', data: { ...plan, others, keepMine: () => settle(true), takeTheirs: () => settle(false) } },
      ),
    );
  }

  return { meet, decide, leaveGone, end: () => (others = {}) };
}
