// @ts-check
/**
 * Edits of runs that are not open: from a review that the user left before the server had stored them, or from an
 * earlier visit. They are sent in order, directly from the outbox, which other pages share: an operation that another
 * page has sent is no longer in it.
 *
 * @typedef {import('./outbox.js').Pending} Pending
 *
 * @typedef {object} BackgroundSender
 * @property {(run: string|null) => Promise<void>} setOpenRun   leave the edits of this run to the editor; resolves when no request for it is pending here
 * @property {() => Promise<void>} flush     send the operations in the outbox; resolves when only those that wait for a decision are left
 * @property {() => void} retry           try again now
 */
import { ApiError, errorMessage } from '../api/errors.js';
import { plural } from '../model/format.js';
import { hideBanner, setElsewhere, showBanner } from '../store/actions/page.js';
import { withCounterparts, withoutUndone } from './pending.js';
import {
  FILE_CHANGED,
  FILES_ELSEWHERE,
  createWakeableSleep,
  isRetryableEdit,
  withoutMissingLabel,
  removeStored,
  retryDelay,
} from './sending.js';
import { commandName, withTrackNames } from './command_names.js';

/** After this time without a change, no open page is still moving a box by keys, ms. */
const MAX_KEY_PAUSE_MS = 2000;

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'edit'|'annotation'>} parts.api
 * @param {import('./outbox.js').Outbox} parts.outbox
 * @param {AbortSignal} parts.signal
 * @param {import('../core/toast.js').Notify} parts.toast
 * @param {(ms: number) => Promise<void>} [parts.sleep]
 * @returns {BackgroundSender}
 */
export function createBackgroundSender({ store, api, outbox, signal, toast, sleep: givenSleep }) {
  const { sleep: wait, wake } = createWakeableSleep();
  const sleep = givenSleep ?? wait;
  /** @type {string|null} */
  let openRun = null;
  /** Runs whose next edit needs a decision of the user. @type {Set<string>} */
  const undecided = new Set();
  /** @type {{run: string, finished: Promise<unknown>}|null} */
  let inFlight = null;
  /** @type {Promise<void>|null} */
  let flushing = null;
  /** The outbox may have new operations since it was read. */
  let outboxChanged = false;

  /** @param {readonly Pending[]} left */
  function showUnsaved(left) {
    /** @type {Map<string, number>} */
    const counts = new Map();
    for (const { run } of left) counts.set(run, (counts.get(run) ?? 0) + 1);
    const elsewhere = [...counts].map(([run, unsaved]) => ({ run, unsaved, held: undecided.has(run) }));
    const held = elsewhere.filter((one) => one.held).reduce((sum, { unsaved }) => sum + unsaved, 0);
    store.dispatch((state) =>
      setElsewhere(
        held === 0
          ? hideBanner(state, 'elsewhere')
          : showBanner(state, {
              id: 'elsewhere',
              tone: 'warning',
              action: { label: 'Open it', operation: 'open-undecided' },
              text: `${held === 1 ? 'A change' : `${held} changes`} of another run ${held === 1 ? 'is' : 'are'} not saved: somebody else changed the same track first.`,
            }),
        elsewhere,
      ),
    );
  }

  /** The operations of the runs that are not open. @returns {Promise<Pending[]>} */
  async function readOutbox() {
    const left = (await outbox.all().catch(() => [])).filter(({ run }) => run !== openRun);
    showUnsaved(left);
    return left;
  }

  /** @param {Pending} next */
  async function send(next) {
    let sent = next;
    if (Reflect.get(next.command, 'op_id') === '') {
      const name = /** @type {'undo'|'redo'} */ (next.command.name);
      const about = (await api.annotation(next.run, next.author, { signal }))[name];
      if (about === null) return void (await giveUp(next));
      sent = { ...next, command: { name, op_id: about.op_id }, about };
    }
    const answer = await api.edit(sent.run, { op_id: sent.op_id, author: sent.author, command: sent.command }, sent.seen, { signal });
    await removeStored(
      outbox,
      sent,
      answer.docs,
      (await outbox.load(sent.run)).filter(({ op_id }) => op_id !== sent.op_id),
    );
  }

  /** @param {Pending} next */
  async function giveUp(next) {
    for (const { op_id } of withCounterparts(await outbox.load(next.run), next)) await outbox.remove(op_id);
  }

  /** @param {Pending} next @param {unknown} thrown */
  async function onRefused(next, thrown) {
    const ofRun = await outbox.load(next.run);
    const current = ofRun.find(({ op_id }) => op_id === next.op_id);
    // another page has sent it, or the operation before it
    if (!current || JSON.stringify(current.seen) !== JSON.stringify(next.seen)) return;
    const code = thrown instanceof ApiError ? thrown.code : '';
    const reverts = next.command.name === 'undo' || next.command.name === 'redo';
    const unlabelled = withoutMissingLabel(next, thrown);
    if (code === 'stale' && !reverts && withoutUndone(ofRun).includes(current)) {
      undecided.add(next.run);
    } else if (thrown instanceof ApiError && thrown.status === 404) {
      for (const { op_id } of ofRun) await outbox.remove(op_id);
      toast(`${plural(ofRun.length, 'unsaved change')} ${ofRun.length === 1 ? 'is' : 'are'} given up: the run was removed.`, {
        tone: 'bad',
      });
    } else if (unlabelled !== null) {
      await outbox.put(unlabelled);
      toast(`A new track has no label yet. ${errorMessage(thrown)}`, { tone: 'bad', stays: true });
    } else {
      await giveUp(next);
      if (code !== 'stale' || reverts)
        toast(`${commandName(next.command.name)} was not possible. ${withTrackNames(errorMessage(thrown), {})}`, { tone: 'bad' });
    }
  }

  async function sendAll() {
    /** Runs whose video file has changed or belongs to another server. The other runs do not wait for them. @type {Set<string>} */
    const unavailable = new Set();
    for (let attempts = 0; !signal.aborted;) {
      outboxChanged = false;
      const left = (await readOutbox()).filter(({ run }) => !undecided.has(run));
      const next = left.find(({ run }) => !unavailable.has(run));
      if (next === undefined) {
        if (left.length > 0) {
          unavailable.clear();
          await sleep(retryDelay(attempts++));
        } else if (!outboxChanged) return;
        continue;
      }
      if (next.growing) {
        await sleep(MAX_KEY_PAUSE_MS);
        const current = (await outbox.load(next.run)).find(({ op_id }) => op_id === next.op_id);
        if (!current || JSON.stringify(current.command) !== JSON.stringify(next.command)) continue;
      }
      if (next.run === openRun) continue;
      const finished = send(next);
      inFlight = { run: next.run, finished: finished.catch(() => {}) };
      try {
        await finished;
        attempts = 0;
      } catch (thrown) {
        if (signal.aborted) return;
        if (isRetryableEdit(thrown) && (thrown.code === FILE_CHANGED || thrown.code === FILES_ELSEWHERE)) unavailable.add(next.run);
        else if (isRetryableEdit(thrown)) await sleep(retryDelay(attempts++));
        else await onRefused(next, thrown);
      } finally {
        inFlight = null;
      }
    }
  }

  return {
    async setOpenRun(run) {
      openRun = run;
      if (run !== null) undecided.delete(run);
      store.dispatch((state) =>
        setElsewhere(
          state,
          state.elsewhere.filter((one) => one.run !== run),
        ),
      );
      if (inFlight?.run === run) await inFlight.finished;
    },
    flush() {
      outboxChanged = true;
      if (flushing !== null) void readOutbox(); // it may be pausing
      flushing ??= sendAll().finally(() => (flushing = null));
      return flushing;
    },
    retry: wake,
  };
}
