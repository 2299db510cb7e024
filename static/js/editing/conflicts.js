// @ts-check
/**
 * Edits that the server refuses because another person changed the track first: held until the user decides, or
 * resolved automatically.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./outbox.js').Pending} Pending
 */
import { listNames, trackName } from '../model/track_name.js';
import { hideBanner, openDialog, showBanner } from '../store/actions/page.js';
import { seek, select } from '../store/actions/review.js';
import { changesNothing, planKeepMine } from './conflict_plan.js';
import { keysOf, splitOffDependents, seenRevisions, withoutUndone, withoutTracks } from './pending.js';

/** Maximum number of tracks that a notice names. */
const MAX_NAMED_TRACKS = 5;

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {import('./outbox.js').Outbox} parts.outbox
 * @param {import('./editor_state.js').EditorState} parts.edits
 * @param {import('../core/toast.js').Notify} parts.toast
 * @param {(command: Command) => void} parts.enqueue
 * @param {() => Promise<void>} parts.refresh
 */
export function createConflicts({ store, outbox, edits, toast, enqueue, refresh }) {
  /** Last change, and its author, of the tracks with held edits. @type {Record<string, import('./conflict_plan.js').Last>} */
  let lastChanges = {};

  /**
   * @param {Pending} next                    the refused operation
   * @param {readonly TrackDoc[]} current     tracks in the other person's version
   * @param {typeof lastChanges} authors                authors of the other changes
   */
  async function handle(next, current, authors) {
    edits.confirm(current);
    // undone before it was sent: there is no conflict
    if (!withoutUndone(edits.pending).includes(next)) edits.forget(next);
    else if (!dropChangedTracks(next, current) && !rebaseNote(next)) await hold(next, authors);
  }

  /** Hold an operation and the later ones that build on it until the user decides. @param {Pending} next @param {typeof lastChanges} authors */
  async function hold(next, authors) {
    const { held, left } = splitOffDependents(edits.pending, next);
    const effective = withoutUndone(held);
    for (const one of held) if (!effective.includes(one)) outbox.remove(one.op_id).catch(() => {});
    edits.pending = left;
    edits.held = [...edits.held, ...effective];
    lastChanges = { ...lastChanges, ...authors };
    await refresh(); // includes the tracks that it was merged into
    decide();
  }

  /**
   * Leave the tracks that have changed out of a verdict on several tracks; the others get it.
   * @param {Pending} next
   * @param {readonly TrackDoc[]} current   the tracks that somebody else has changed
   */
  function dropChangedTracks(next, current) {
    const reduced = withoutTracks(
      next,
      current.map(({ key }) => key),
    );
    if (reduced === next) return false;
    if (reduced === null) edits.forget(next);
    else edits.replace(reduced);
    const names = listNames(
      current.map(({ key }) => trackName(key, edits.confirmed[key])),
      MAX_NAMED_TRACKS,
    );
    toast(`No verdict on ${current.length === 1 ? 'track' : 'tracks'} ${names}: changed by somebody else first.`, { stays: true });
    return true;
  }

  /** Repeat a note on top of the other change, which it cannot contradict. Not if other operations of ours build on it. @param {Pending} next */
  function rebaseNote(next) {
    const review = store.get().review;
    const key = next.command.name === 'add_note' ? /** @type {Command} */ (next.command).key : null;
    if (
      review === null ||
      key === null ||
      edits.confirmed[key]?.gone ||
      edits.pending.filter((one) => keysOf(one).includes(key)).length > 1
    )
      return false;
    edits.replace({ ...next, seen: seenRevisions(review, edits.confirmed, next.command) });
    return true;
  }

  /** If the selected track no longer exists, select the track that it is part of. */
  function leaveDeletedTrack() {
    const { selected, docs } = store.get().review ?? { selected: null, docs: {} };
    const doc = selected === null ? undefined : docs[selected];
    if (!doc?.gone) return null;
    store.dispatch(select, doc.merged_into);
    return doc;
  }

  /** Show both versions of what is held, and let a person choose. */
  function decide() {
    const review = store.get().review;
    const { held } = edits;
    if (held.length === 0 || review === null) return;
    const plan = planKeepMine(review, edits.confirmed, held, new Date().toISOString());
    /** @param {boolean} keepMine */
    const resolve = (keepMine) => {
      const held = edits.held;
      edits.held = [];
      lastChanges = {};
      store.dispatch(hideBanner, 'conflict');
      // changes that arrived since the dialog was opened count too
      const { commands } = keepMine ? planKeepMine(store.get().review ?? review, edits.confirmed, held, '') : { commands: [] };
      for (const command of commands) enqueue(command);
      // only now: if the page closes before this point, it asks again and nothing is lost
      for (const one of held) outbox.remove(one.op_id).catch(() => {});
      edits.show();
      const last = commands.at(-1);
      // show the result, also if it went to another track
      if (last) store.dispatch((state) => select(seek(state, last.frame), last.key));
      leaveDeletedTrack();
    };
    if (changesNothing(plan)) {
      resolve(false);
      return;
    }
    const text = `${held.length === 1 ? 'A change is' : `${held.length} changes are`} not saved: somebody else changed the same track first.`;
    const data = { ...plan, others: lastChanges, keepMine: () => resolve(true), takeTheirs: () => resolve(false) };
    store.dispatch((state) => {
      const action = { label: 'Decide', operation: 'decide-conflict' };
      const withBanner = showBanner(state, { id: 'conflict', tone: 'warning', text, action });
      // another dialog may hold input, a drawn box or an import: the banner opens this one later
      return (state.dialog?.kind ?? 'conflict') === 'conflict' ? openDialog(withBanner, { kind: 'conflict', data }) : withBanner;
    });
  }

  return { handle, decide, leaveDeletedTrack, clear: () => (lastChanges = {}) };
}
