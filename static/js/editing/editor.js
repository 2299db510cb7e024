// @ts-check
/**
 * Edits from the moment they are made until the server has stored them. An edit is shown at once, kept in the outbox,
 * sent after those before it, and sent again until it arrives. An edit in conflict with another person's change is held
 * until the user decides. Unsent edits of a review that the user has left are sent in the background.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('./outbox.js').Outbox} Outbox
 */
import { ApiError, errorMessage } from '../api/errors.js';
import { readOnlyReason } from '../model/team.js';
import { CommandError, applyCommand } from '../model/commands.js';
import { plural } from '../model/format.js';
import { withLabelKey } from '../model/labels.js';
import { isOpening } from '../model/review_notice.js';
import { trackName } from '../model/track_name.js';
import { hideBanner, showBanner } from '../store/actions/page.js';
import { changeReview } from '../store/actions/review.js';
import { createConflicts } from './conflicts.js';
import { createKeyMoves } from './key_moves.js';
import { reconcile } from './undo_history.js';
import { asCommand, withCounterparts, rebase, seenRevisions } from './pending.js';
import { createDocumentReader } from './document_reader.js';
import { docsFor } from './revisions.js';
import { createWakeableSleep, isRetryableEdit, withoutMissingLabel, removeStored, retryDelay } from './sending.js';
import { createUndo } from './undo.js';
import { commandName, withTrackNames, STILL_OPENING } from './command_names.js';
import { createEditorState } from './editor_state.js';
import { randomId } from '../core/random_id.js';

/**
 * @typedef {object} Editor
 * @property {(run: string) => Promise<void>} open   load a run's documents and its operations in the outbox
 * @property {() => void} close
 * @property {(command: Command, run?: string|null, gesture?: string) => boolean} edit   false: the command is not
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
 * @param {import('./background_sender.js').BackgroundSender} parts.backgroundSender
 * @param {AbortSignal} parts.signal
 * @param {import('../core/toast.js').Notify} parts.toast
 * @param {() => string} parts.author
 * @param {() => void} [parts.onEdit]   called for each edit, before it is shown
 * @param {(ms: number) => Promise<void>} [parts.sleep]
 * @param {() => string} [parts.newId]
 * @returns {Editor}
 */
export function createEditor({
  store,
  api,
  outbox,
  backgroundSender,
  signal,
  toast,
  author,
  onEdit = () => {},
  sleep: givenSleep,
  newId = randomId,
}) {
  const edits = createEditorState(store, outbox);
  const keyMoves = createKeyMoves(edits);
  const { sleep: wait, wake } = createWakeableSleep();
  const sleep = givenSleep ?? wait;
  const { read, refresh, refreshHistory } = createDocumentReader({ store, api, edits, author, sleep, signal });
  const conflicts = createConflicts({ store, outbox, edits, toast, enqueue, refresh });
  const undo = createUndo({ store, edits, toast, enqueue, refresh });
  let sending = false;
  /** The current request, also for a run that the user has left since. @type {Promise<unknown>} */
  let inFlight = Promise.resolve();
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
    keyMoves.end();
    if (edits.run === null || review === null) return op_id;
    onEdit();
    const operation = { op_id, author: author(), command, ...(about && { about }) };
    if (!edits.ready) {
      edits.early = [...edits.early, operation];
      edits.show();
      // the person saw tracks that nobody has touched, so those revisions are kept
      edits.save({ ...operation, run: edits.run, seen: seenRevisions(review, {}, command) });
      return op_id;
    }
    const pending = {
      ...operation,
      run: edits.run,
      seen: seenRevisions(review, edits.confirmed, command),
      ...(gesture !== undefined && { growing: true }),
    };
    edits.pending = [...edits.pending, pending];
    if (gesture !== undefined) keyMoves.begin(op_id, gesture);
    edits.show();
    edits.save(pending);
    void send();
    return op_id;
  }

  /** Send one operation. If the user has left its run meanwhile, the later operations are only in the outbox. @param {Pending} next @param {string} run */
  async function transmit(next, run) {
    const answer = await api.edit(run, { op_id: next.op_id, author: next.author, command: next.command }, next.seen, { signal });
    if (edits.run !== run)
      await removeStored(
        outbox,
        next,
        answer.docs,
        (await outbox.load(run)).filter(({ op_id }) => op_id !== next.op_id),
      ).catch(() => {});
    return answer;
  }

  async function send() {
    if (sending || !edits.ready) return;
    sending = true;
    let attempts = 0;
    while (edits.pending.length && edits.run !== null && !signal.aborted) {
      const run = edits.run;
      await keyMoves.finished(edits.pending[0].op_id);
      if (edits.run !== run) continue;
      let next = edits.pending[0];
      try {
        const resolved = asCommand(next.command) === null ? await undo.resolveTarget(next) : next;
        if (edits.run !== run) continue;
        if (resolved === null) {
          edits.forget(next);
          toast(`There is nothing to ${next.command.name}.`, { topic: 'undo' });
          edits.show();
          continue;
        }
        if (resolved !== next) edits.replace((next = resolved));
        const request = transmit(next, run);
        inFlight = request.catch(() => {});
        const answer = await request;
        if (edits.run !== run) continue;
        attempts = 0;
        onStored(next, answer);
      } catch (thrown) {
        if (signal.aborted) break;
        if (edits.run !== run) continue;
        if (isRetryableEdit(thrown)) {
          if (thrown.code !== 'offline') {
            store.dispatch(showBanner, {
              id: 'saving',
              tone: 'warning',
              text: `${thrown.message} Your changes are kept in this page and sent again.`,
            });
          }
          await sleep(retryDelay(attempts++));
          continue;
        }
        await onRefused(next, thrown);
      }
    }
    sending = false;
    if (edits.pending.length === 0) for (const resolve of waiters.splice(0)) resolve();
  }

  /** @param {Pending} next @param {import('../types.js').EditAnswer} answer */
  function onStored(next, answer) {
    edits.recordStored(next, answer.docs);
    const later = edits.pending.filter(({ op_id }) => op_id !== next.op_id);
    removeStored(outbox, next, answer.docs, later).catch(() => {});
    edits.pending = rebase(later, answer.docs).pending;
    edits.confirm(answer.docs);
    edits.history = reconcile(edits.history, answer);
    store.dispatch((state) => hideBanner(changeReview(state, { seq: answer.seq }), 'saving'));
    edits.show();
    undo.onStored(next, answer.docs);
  }

  /** @param {Pending} next @param {unknown} thrown */
  async function onRefused(next, thrown) {
    const unlabelled = withoutMissingLabel(next, thrown);
    if (asCommand(next.command) === null) {
      edits.forget(next);
      undo.onRefused(next, thrown);
      await refresh();
    } else if (thrown instanceof ApiError && thrown.code === 'stale') {
      await conflicts.handle(next, thrown.details.current ?? [], thrown.details.by ?? {});
    } else if (unlabelled !== null) {
      edits.replace(unlabelled);
      toast(`The new track has no label yet. ${errorMessage(thrown)}`, { tone: 'bad', stays: true });
    } else {
      edits.forget(next);
      const why = withTrackNames(errorMessage(thrown), store.get().review?.docs ?? {});
      toast(`${commandName(next.command.name)} was not possible. ${why}`, { tone: 'bad' });
    }
    edits.show();
  }

  /** @returns {Promise<void>} */
  function settled() {
    keyMoves.end();
    return edits.pending.length === 0 && !sending ? Promise.resolve() : new Promise((resolve) => waiters.push(() => resolve(undefined)));
  }

  /** @param {'undo'|'redo'} what */
  function revert(what) {
    keyMoves.end();
    undo.revert(what);
    return settled();
  }

  /** @param {Command} command @param {string|null} [run]   the run that it is meant for @param {string} [gesture] @param {string} [op_id] */
  function edit(command, run = edits.run, gesture, op_id) {
    const { review, session } = store.get();
    const reason = readOnlyReason(session);
    if (reason !== null) {
      toast(reason, { tone: 'bad', topic: 'role' });
      return false;
    }
    if (run !== edits.run) {
      toast(`${commandName(command.name)} was not possible: it was meant for the run that was open before.`, { tone: 'bad' });
      return false;
    }
    if (review === null || edits.run === null) {
      if (isOpening(store.get())) toast(`${commandName(command.name)} was not possible: ${STILL_OPENING}.`, { tone: 'bad' });
      return false;
    }
    if (edits.ready) {
      try {
        applyCommand({ ...docsFor(review, command), ...review.docs }, command, { author: author(), time: '' });
      } catch (thrown) {
        if (!(thrown instanceof CommandError)) throw thrown;
        toast(withTrackNames(thrown.message, review.docs), { tone: 'bad' });
        return false;
      }
    }
    if (gesture === undefined || !keyMoves.extend(command, gesture))
      enqueue(withLabelKey(command, store.get().labels), undefined, gesture, op_id);
    return true;
  }

  /** Apply the edits that were made before the documents arrived. An edit that is not possible on them is dropped, and so is its undo. @param {import('./editor_state.js').EarlyEdit[]} early */
  function applyEarly(early) {
    for (let remaining = early; remaining.length > 0;) {
      const { op_id, command, about } = remaining[0];
      const change = asCommand(command);
      const made =
        change !== null
          ? edit(change, edits.run, undefined, op_id)
          : about !== undefined && undo.revert(/** @type {'undo'|'redo'} */ (command.name), op_id);
      const finished = made ? [remaining[0]] : withCounterparts(remaining, remaining[0]);
      if (!made) for (const one of finished) outbox.remove(one.op_id).catch(() => {});
      remaining = remaining.filter((one) => !finished.includes(one));
    }
  }

  return {
    async open(run) {
      edits.reset(run);
      await Promise.all([inFlight, backgroundSender.setOpenRun(run)]);
      if (edits.run !== run) return;
      const [annotation, stored] = await Promise.all([read(run), outbox.load(run).catch(() => [])]);
      if (annotation === null || edits.run !== run) return;
      void backgroundSender.flush(); // it has nothing left to send for this run
      edits.confirm(annotation.docs);
      const early = edits.early;
      edits.early = [];
      const unsent = stored.filter((one) => !early.some(({ op_id }) => op_id === one.op_id));
      edits.pending = unsent;
      edits.history = reconcile(edits.history, annotation);
      edits.ready = true;
      store.dispatch(changeReview, { seq: annotation.seq });
      edits.show();
      if (unsent.length) toast(`${plural(unsent.length, 'change')} of an earlier visit ${unsent.length === 1 ? 'is' : 'are'} being saved.`);
      applyEarly(early);
      if (edits.isOutdated) void refreshHistory();
      void send();
    },
    close() {
      keyMoves.end();
      edits.reset(null);
      conflicts.clear();
      // both are shown again when the run is opened again
      store.dispatch((state) => hideBanner(hideBanner(state, 'conflict'), 'saving'));
      wake();
      const request = inFlight;
      void request.then(async () => {
        await backgroundSender.setOpenRun(edits.run);
        await backgroundSender.flush();
      });
    },
    edit,
    undo: () => revert('undo'),
    redo: () => revert('redo'),
    receive(docs, op_id, by) {
      if (edits.pending.some((one) => one.op_id === op_id)) return; // the answer to it will bring the documents
      if (!edits.ready) {
        // without the operations in the outbox, they would look lost
        edits.isOutdated = true;
        return edits.confirm(docs);
      }
      const selected = store.get().review?.selected ?? null;
      const wasPresent = selected !== null && !store.get().review?.docs[selected]?.gone;
      edits.confirm(docs);
      const next = [edits.history.done.at(-1), edits.history.undone.at(-1)].flatMap((one) => one?.keys ?? []);
      // the user's own work in another page, or a change that makes the user's next edits impossible
      if (!edits.stored.has(op_id) && (by === author() || docs.some(({ key }) => next.includes(key)))) void refreshHistory();
      edits.show();
      const doc = wasPresent ? conflicts.leaveDeletedTrack() : null;
      if (doc)
        toast(
          `Track ${trackName(doc.key, doc)} was ${doc.merged_into ? `merged into ${trackName(doc.merged_into)}` : 'deleted'} in another page.`,
          { stays: true },
        );
    },
    refresh,
    settled,
    retry() {
      keyMoves.end();
      wake();
      backgroundSender.retry();
    },
    decide: conflicts.decide,
  };
}
