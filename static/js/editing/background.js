// @ts-check
/**
 * Edits of runs that are not open: from a review that the user left before the server had stored them, or from an
 * earlier visit. They are sent in order, directly from the outbox, which other pages share: an operation that another
 * page has sent is no longer in it.
 *
 * @typedef {import('./outbox.js').Pending} Pending
 *
 * @typedef {object} Background
 * @property {(run: string|null) => Promise<void>} except   leave the edits of this run to the editor; resolves when no request for it is pending here
 * @property {() => Promise<void>} go     send the operations in the outbox; resolves when only those that wait for a decision are left
 * @property {() => void} retry           try again now
 */
import { ApiError, sentence } from '../api/errors.js';
import { hideBanner, setElsewhere, showBanner } from '../store/actions/page.js';
import { givenUp, standing } from './pending.js';
import { CHANGED, ELSEWHERE, createPause, isPassing, keptWithoutLabel, leave, pauseAfter } from './sending.js';
import { describe, named } from './words.js';

/** After this time without a change, no open page is still moving a box by keys, ms. */
const RESTS = 2000;

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'edit'|'annotation'>} parts.api
 * @param {import('./outbox.js').Outbox} parts.outbox
 * @param {AbortSignal} parts.signal
 * @param {(text: string, options?: import('../core/toast.js').ToastOptions) => void} parts.toast
 * @param {(ms: number) => Promise<void>} [parts.pause]
 * @returns {Background}
 */
export function createBackground({ store, api, outbox, signal, toast, pause }) {
  const { wait, wake } = createPause();
  const rest = pause ?? wait;
  /** @type {string|null} */
  let open = null;
  /** Runs whose next edit needs a decision of the user. @type {Set<string>} */
  const stuck = new Set();
  /** @type {{run: string, ends: Promise<unknown>}|null} */
  let flight = null;
  /** @type {Promise<void>|null} */
  let going = null;
  /** The outbox may have new operations since it was read. */
  let again = false;

  /** @param {readonly Pending[]} left */
  function tell(left) {
    /** @type {Map<string, number>} */
    const counts = new Map();
    for (const { run } of left) counts.set(run, (counts.get(run) ?? 0) + 1);
    const elsewhere = [...counts].map(([run, unsaved]) => ({ run, unsaved, held: stuck.has(run) }));
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

  /** The operations that are left to send here. @returns {Promise<Pending[]>} */
  async function look() {
    const left = (await outbox.all().catch(() => [])).filter(({ run }) => run !== open);
    tell(left);
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
    await leave(
      outbox,
      sent,
      answer.docs,
      (await outbox.load(sent.run)).filter(({ op_id }) => op_id !== sent.op_id),
    );
  }

  /** @param {Pending} next */
  async function giveUp(next) {
    for (const { op_id } of givenUp(await outbox.load(next.run), next)) await outbox.remove(op_id);
  }

  /** @param {Pending} next @param {unknown} thrown */
  async function refused(next, thrown) {
    const mine = await outbox.load(next.run);
    const now = mine.find(({ op_id }) => op_id === next.op_id);
    // another page has sent it, or the operation before it
    if (!now || JSON.stringify(now.seen) !== JSON.stringify(next.seen)) return;
    const code = thrown instanceof ApiError ? thrown.code : '';
    const reverts = next.command.name === 'undo' || next.command.name === 'redo';
    if (code === 'stale' && !reverts && standing(mine).includes(now)) {
      stuck.add(next.run);
    } else if (thrown instanceof ApiError && thrown.status === 404) {
      for (const { op_id } of mine) await outbox.remove(op_id);
      toast(`${mine.length} unsaved change${mine.length === 1 ? ' is' : 's are'} given up: the run was removed.`, { tone: 'bad' });
    } else if (keptWithoutLabel(next, thrown) !== null) {
      await outbox.put(/** @type {Pending} */ (keptWithoutLabel(next, thrown)));
      toast(`A new track has no label yet. ${sentence(thrown)}`, { tone: 'bad', stays: true });
    } else {
      await giveUp(next);
      if (code !== 'stale' || reverts)
        toast(`${describe(next.command.name)} was not possible. ${named(sentence(thrown), {})}`, { tone: 'bad' });
    }
  }

  async function rounds() {
    /** Runs whose video file has changed or belongs to another server. The other runs do not wait for them. @type {Set<string>} */
    const changed = new Set();
    for (let tries = 0; !signal.aborted;) {
      again = false;
      const left = (await look()).filter(({ run }) => !stuck.has(run));
      const next = left.find(({ run }) => !changed.has(run));
      if (next === undefined) {
        if (left.length > 0) {
          changed.clear();
          await rest(pauseAfter(tries++));
        } else if (!again) return;
        continue;
      }
      if (next.growing) {
        await rest(RESTS);
        const now = (await outbox.load(next.run)).find(({ op_id }) => op_id === next.op_id);
        if (!now || JSON.stringify(now.command) !== JSON.stringify(next.command)) continue;
      }
      if (next.run === open) continue;
      const ends = send(next);
      flight = { run: next.run, ends: ends.catch(() => {}) };
      try {
        await ends;
        tries = 0;
      } catch (thrown) {
        if (signal.aborted) return;
        if (isPassing(thrown) && (thrown.code === CHANGED || thrown.code === ELSEWHERE)) changed.add(next.run);
        else if (isPassing(thrown)) await rest(pauseAfter(tries++));
        else await refused(next, thrown);
      } finally {
        flight = null;
      }
    }
  }

  return {
    async except(run) {
      open = run;
      if (run !== null) stuck.delete(run);
      store.dispatch((state) =>
        setElsewhere(
          state,
          state.elsewhere.filter((one) => one.run !== run),
        ),
      );
      if (flight?.run === run) await flight.ends;
    },
    go() {
      again = true;
      if (going !== null) void look(); // it may be pausing
      going ??= rounds().finally(() => (going = null));
      return going;
    },
    retry: wake,
  };
}
