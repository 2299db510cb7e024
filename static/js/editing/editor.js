// @ts-check
/**
 * Edits from the moment they are made until the server has stored them. An edit is shown at once, kept in the outbox,
 * sent after those before it, and repeated until it arrives. An edit in conflict with another person's change is held
 * until the user decides. Unsent edits of a review that the user has left are sent in the background.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('./outbox.js').Outbox} Outbox
 */
import { ApiError, sentence } from '../api/errors.js';
import { readOnly } from '../model/team.js';
import { CommandError, applyCommand } from '../model/commands.js';
import { withLabelKey } from '../model/labels.js';
import { isOpening } from '../model/review_notice.js';
import { trackName } from '../model/track_name.js';
import { hideBanner, showBanner } from '../store/actions/page.js';
import { changeReview } from '../store/actions/review.js';
import { createConflicts } from './conflicts.js';
import { createGrowth } from './growth.js';
import { agreed } from './line.js';
import { asCommand, givenUp, rebased, revisionsSeen } from './pending.js';
import { createReading } from './reading.js';
import { docsFor } from './revisions.js';
import { createPause, isPassing, keptWithoutLabel, leave, pauseAfter } from './sending.js';
import { createUndoing } from './undoing.js';
import { describe, named, OPENING } from './words.js';
import { createWork } from './work.js';

/**
 * @typedef {object} Editor
 * @property {(run: string) => Promise<void>} open   load a run's documents and its operations in the outbox
 * @property {() => void} close
 * @property {(command: Command, of?: string|null, gesture?: string) => boolean} edit   false: the command is not
 *   possible, or is for another run than the open one; the reason is shown. Boxes that one gesture sets without a pause
 *   are one undo step
 * @property {() => Promise<void>} undo              resolves when the server has stored it
 * @property {() => Promise<void>} redo
 * @property {(docs: TrackDoc[], op_id: string, by?: string) => void} receive   takes documents from the event stream, and their author
 * @property {() => Promise<void>} refresh           read the documents again after missed events
 * @property {() => Promise<void>} settled           resolves when nothing is left to send
 * @property {() => void} retry                      try again now
 * @property {() => void} decide                     ask again about a postponed conflict
 */

/**
 * @param {object} parts
 * @param {Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'edit'|'annotation'>} parts.api
 * @param {Outbox} parts.outbox
 * @param {import('./background.js').Background} parts.background
 * @param {AbortSignal} parts.signal
 * @param {(text: string, options?: import('../core/toast.js').ToastOptions) => void} parts.toast
 * @param {() => string} parts.author
 * @param {() => void} [parts.edited]   called for each edit, before it is shown
 * @param {(ms: number) => Promise<void>} [parts.pause]
 * @param {() => string} [parts.newId]
 * @returns {Editor}
 */
export function createEditor({
  store,
  api,
  outbox,
  background,
  signal,
  toast,
  author,
  edited = () => {},
  pause,
  newId = () => crypto.randomUUID(),
}) {
  const work = createWork(store, outbox);
  const growth = createGrowth(work);
  const { wait, wake } = createPause();
  const rest = pause ?? wait;
  const { read, refresh, askAnew } = createReading({ store, api, work, author, rest, signal });
  const conflicts = createConflicts({ store, outbox, work, toast, enqueue, refresh });
  const undoing = createUndoing({ store, work, toast, enqueue, refresh });
  let sending = false;
  /** The current request, also for a run that the user has left since. @type {Promise<unknown>} */
  let flight = Promise.resolve();
  /** @type {(() => void)[]} */
  const waiters = [];

  /**
   * @param {Pending['command']} command
   * @param {import('../types.js').UndoTarget} [about]
   * @param {string} [gesture]
   * @param {string} [op_id]
   * @returns {string} its op_id
   */
  function enqueue(command, about, gesture, op_id = newId()) {
    const { review } = store.get();
    growth.end();
    if (work.run === null || review === null) return op_id;
    edited();
    const made = { op_id, author: author(), command, ...(about && { about }) };
    if (!work.ready) {
      work.early = [...work.early, made];
      work.show();
      // the person saw tracks that nobody has touched, so those revisions are kept
      work.keep({ ...made, run: work.run, seen: revisionsSeen(review, {}, command) });
      return op_id;
    }
    const pending = {
      ...made,
      run: work.run,
      seen: revisionsSeen(review, work.confirmed, command),
      ...(gesture !== undefined && { growing: true }),
    };
    work.pending = [...work.pending, pending];
    if (gesture !== undefined) growth.begin(op_id, gesture);
    work.show();
    work.keep(pending);
    void send();
    return op_id;
  }

  /** Send one operation. If the user has left its run meanwhile, the later operations are only in the outbox. @param {Pending} next @param {string} here */
  async function transmit(next, here) {
    const answer = await api.edit(here, { op_id: next.op_id, author: next.author, command: next.command }, next.seen, { signal });
    if (work.run !== here)
      await leave(
        outbox,
        next,
        answer.docs,
        (await outbox.load(here)).filter(({ op_id }) => op_id !== next.op_id),
      ).catch(() => {});
    return answer;
  }

  async function send() {
    if (sending || !work.ready) return;
    sending = true;
    let tries = 0;
    while (work.pending.length && work.run !== null && !signal.aborted) {
      const here = work.run;
      await growth.over(work.pending[0].op_id);
      if (work.run !== here) continue;
      let next = work.pending[0];
      try {
        const resolved = asCommand(next.command) === null ? await undoing.resolved(next) : next;
        if (work.run !== here) continue;
        if (resolved === null) {
          work.forget(next);
          toast(`There is nothing to ${next.command.name}.`, { topic: 'undo' });
          work.show();
          continue;
        }
        if (resolved !== next) work.replace((next = resolved));
        const under = transmit(next, here);
        flight = under.catch(() => {});
        const answer = await under;
        if (work.run !== here) continue;
        tries = 0;
        stored(next, answer);
      } catch (thrown) {
        if (signal.aborted) break;
        if (work.run !== here) continue;
        if (isPassing(thrown)) {
          if (thrown.code !== 'offline') {
            store.dispatch(showBanner, {
              id: 'saving',
              tone: 'warning',
              text: `${thrown.message} Your changes are kept in this page and sent again.`,
            });
          }
          await rest(pauseAfter(tries++));
          continue;
        }
        await refused(next, thrown);
      }
    }
    sending = false;
    if (work.pending.length === 0) for (const resolve of waiters.splice(0)) resolve();
  }

  /** @param {Pending} next @param {import('../types.js').EditAnswer} answer */
  function stored(next, answer) {
    work.remember(next, answer.docs);
    const behind = work.pending.filter(({ op_id }) => op_id !== next.op_id);
    leave(outbox, next, answer.docs, behind).catch(() => {});
    work.pending = rebased(behind, answer.docs).pending;
    work.confirm(answer.docs);
    work.line = agreed(work.line, answer);
    store.dispatch((state) => hideBanner(changeReview(state, { seq: answer.seq }), 'saving'));
    work.show();
    undoing.stored(next, answer.docs);
  }

  /** @param {Pending} next @param {unknown} thrown */
  async function refused(next, thrown) {
    if (asCommand(next.command) === null) {
      work.forget(next);
      undoing.refused(next, thrown);
      await refresh();
    } else if (thrown instanceof ApiError && thrown.code === 'stale') {
      await conflicts.meet(next, thrown.details.current ?? [], thrown.details.by ?? {});
    } else if (keptWithoutLabel(next, thrown) !== null) {
      work.replace(/** @type {Pending} */ (keptWithoutLabel(next, thrown)));
      toast(`The new track has no label yet. ${sentence(thrown)}`, { tone: 'bad', stays: true });
    } else {
      work.forget(next);
      const why = thrown instanceof ApiError ? thrown.message : sentence(thrown);
      toast(`${describe(next.command.name)} was not possible. ${named(why, store.get().review?.docs ?? {})}`, { tone: 'bad' });
    }
    work.show();
  }

  /** @returns {Promise<void>} */
  function settled() {
    growth.end();
    return work.pending.length === 0 && !sending ? Promise.resolve() : new Promise((resolve) => waiters.push(() => resolve(undefined)));
  }

  /** @param {'undo'|'redo'} what */
  function revert(what) {
    growth.end();
    undoing.press(what);
    return settled();
  }

  /** @param {Command} command @param {string|null} [of]   the run that it is meant for @param {string} [gesture] @param {string} [op_id] */
  function edit(command, of = work.run, gesture, op_id) {
    const { review, session } = store.get();
    const barred = readOnly(session);
    if (barred !== null) {
      toast(barred, { tone: 'bad', topic: 'role' });
      return false;
    }
    if (of !== work.run) {
      toast(`${describe(command.name)} was not possible: it was meant for the run that was open before.`, { tone: 'bad' });
      return false;
    }
    if (review === null || work.run === null) {
      if (isOpening(store.get())) toast(`${describe(command.name)} was not possible: ${OPENING}.`, { tone: 'bad' });
      return false;
    }
    if (work.ready) {
      try {
        applyCommand({ ...docsFor(review, command), ...review.docs }, command, { author: author(), time: '' });
      } catch (thrown) {
        if (!(thrown instanceof CommandError)) throw thrown;
        toast(named(thrown.message, review.docs), { tone: 'bad' });
        return false;
      }
    }
    if (gesture === undefined || !growth.goOn(command, gesture))
      enqueue(withLabelKey(command, store.get().labels), undefined, gesture, op_id);
    return true;
  }

  /** Apply the edits that were made before the documents arrived. An edit that is not possible on them is dropped, and so is its undo. @param {import('./work.js').Early[]} early */
  function make(early) {
    for (let left = early; left.length > 0;) {
      const { op_id, command, about } = left[0];
      const own = asCommand(command);
      const made =
        own !== null
          ? edit(own, work.run, undefined, op_id)
          : about !== undefined && undoing.press(/** @type {'undo'|'redo'} */ (command.name), op_id);
      const gone = made ? [left[0]] : givenUp(left, left[0]);
      if (!made) for (const one of gone) outbox.remove(one.op_id).catch(() => {});
      left = left.filter((one) => !gone.includes(one));
    }
  }

  return {
    async open(wanted) {
      work.begin(wanted);
      await Promise.all([flight, background.except(wanted)]);
      if (work.run !== wanted) return;
      const [annotation, kept] = await Promise.all([read(wanted), outbox.load(wanted).catch(() => [])]);
      if (annotation === null || work.run !== wanted) return;
      void background.go(); // it has nothing left to send for this run
      work.confirm(annotation.docs);
      const made = work.early;
      work.early = [];
      const before = kept.filter((one) => !made.some(({ op_id }) => op_id === one.op_id));
      work.pending = before;
      work.line = agreed(work.line, annotation);
      work.ready = true;
      store.dispatch(changeReview, { seq: annotation.seq });
      work.show();
      if (before.length)
        toast(
          `${before.length} change${before.length === 1 ? '' : 's'} of an earlier visit ${before.length === 1 ? 'is' : 'are'} being saved.`,
        );
      make(made);
      if (work.overtaken) void askAnew();
      void send();
    },
    close() {
      growth.end();
      work.begin(null);
      conflicts.end();
      // both are shown again when the run is opened again
      store.dispatch((state) => hideBanner(hideBanner(state, 'conflict'), 'saving'));
      wake();
      const left = flight;
      void left.then(async () => {
        await background.except(work.run);
        await background.go();
      });
    },
    edit,
    undo: () => revert('undo'),
    redo: () => revert('redo'),
    receive(docs, op_id, by) {
      if (work.pending.some((mine) => mine.op_id === op_id)) return; // the answer to it will bring the documents
      if (!work.ready) {
        // without the operations in the outbox, they would look lost
        work.overtaken = true;
        return work.confirm(docs);
      }
      const looked = store.get().review?.selected ?? null;
      const there = looked !== null && !store.get().review?.docs[looked]?.gone;
      work.confirm(docs);
      const next = [work.line.done.at(-1), work.line.undone.at(-1)].flatMap((one) => one?.keys ?? []);
      // the user's own work in another page, or a change that makes the user's next edits impossible
      if (!work.stored.has(op_id) && (by === author() || docs.some(({ key }) => next.includes(key)))) void askAnew();
      work.show();
      const doc = there ? conflicts.leaveGone() : null;
      if (doc)
        toast(
          `Track ${trackName(doc.key, doc)} was ${doc.merged_into ? `merged into ${trackName(doc.merged_into)}` : 'deleted'} in another page.`,
          { stays: true },
        );
    },
    refresh,
    settled,
    retry() {
      growth.end();
      wake();
      background.retry();
    },
    decide: conflicts.decide,
  };
}
