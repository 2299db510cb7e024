// @ts-check
/**
 * Edits that the server refuses because somebody else was first: held until a person decides, or settled without one.
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

/** Tracks that a notice names. */
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
  /** What was done last, and by whom, to the tracks that edits are held for. @type {Record<string, import('./keeping.js').Last>} */
  let others = {};

  /**
   * @param {Pending} next                    that was refused
   * @param {readonly TrackDoc[]} current     tracks as somebody else has left them
   * @param {typeof others} by                who was first
   */
  async function meet(next, current, by) {
    work.confirm(current);
    // taken back before it arrived: nothing is left to quarrel about
    if (!standing(work.pending).includes(next)) work.forget(next);
    else if (!leaveOut(next, current) && !putOnTop(next)) await hold(next, by);
  }

  /** Until a person decides, with those behind it. @param {Pending} next @param {typeof others} by */
  async function hold(next, by) {
    const { held, left } = parted(work.pending, next);
    const stand = standing(held);
    for (const one of held) if (!stand.includes(one)) outbox.remove(one.op_id).catch(() => {});
    work.pending = left;
    work.held = [...work.held, ...stand];
    others = { ...others, ...by };
    await refresh(); // also those that it was merged into
    decide();
  }

  /**
   * One verdict on many is not for tracks that look otherwise by now; the others get it.
   * @param {Pending} next
   * @param {readonly TrackDoc[]} current   those that somebody else has changed
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
    toast(`No verdict on ${current.length === 1 ? 'track' : 'tracks'} ${names}: somebody else was first.`, { stays: true });
    return true;
  }

  /** A note takes nothing away from what others have said: it goes on top, unless more of ours waits behind it. @param {Pending} next */
  function putOnTop(next) {
    const review = store.get().review;
    const key = next.command.name === 'add_note' ? /** @type {Command} */ (next.command).key : null;
    if (review === null || key === null || work.confirmed[key]?.gone || work.pending.filter((one) => keysOf(one).includes(key)).length > 1)
      return false;
    work.replace({ ...next, seen: revisionsSeen(review, work.confirmed, next.command) });
    return true;
  }

  /** Nobody goes on working on a track that is gone: where the selected one is, what it became part of is selected. */
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
      // what has come in the meantime counts too
      const { commands } = again ? planned(store.get().review ?? review, work.confirmed, bound, '') : { commands: [] };
      for (const command of commands) enqueue(command);
      // only now: a page that dies in between asks once more, and has lost nothing
      for (const one of bound) outbox.remove(one.op_id).catch(() => {});
      work.show();
      const last = commands.at(-1);
      // what became of it is to be seen, also where it went to another track
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
