// @ts-check
/**
 * Edits from the moment they are made until the server has them: shown at once, kept in the outbox, sent one after the
 * other, repeated until they arrive. One that meets somebody else's change is held until a person decides.
 *
 * @typedef {import('../state-types.js').Store} Store
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('../types.js').Command} Command
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('./outbox.js').Outbox} Outbox
 * @typedef {{op_id: string, author: string, command: Command}} Early
 */
import { ApiError, sentence } from '../api/errors.js';
import { CommandError, applyCommand } from '../model/commands.js';
import { subjectOf } from '../model/effective.js';
import { listed, trackName } from '../model/track_name.js';
import { changeReview, select, seek } from '../store/actions/review.js';
import { hideBanner, openDialog, showBanner } from '../store/actions/page.js';
import { isAgreed, planned } from './keeping.js';
import { keysOf, parted, projected, rebased, revisionsSeen, without } from './pending.js';
import { docsFor } from './revisions.js';
import { describe, describeUndone, named } from './words.js';

/** Pauses between tries, ms. */
const PAUSES = [500, 1000, 2000, 4000, 8000, 15000];
/** Tracks that a notice names. */
const NAMED = 5;
/** Answers after which the same operation can never succeed; after all others it is sent again. */
const FINAL = new Set([400, 404, 409, 413, 415, 422, 428]);
/** Code of the one 409 that can pass: another file lies in the place of the video, until it is put back. */
const CHANGED = 'file_changed';

/**
 * @typedef {object} Editor
 * @property {(run: string) => Promise<void>} open   load a run's documents and what the outbox still holds for it
 * @property {() => void} close
 * @property {(command: Command, of?: string|null) => boolean} edit   false: the command makes no sense, or is meant for another run
 *   than the open one; the reason is shown
 * @property {() => Promise<void>} undo
 * @property {() => Promise<void>} redo
 * @property {(docs: TrackDoc[], op_id: string) => void} hear   documents that the event stream brings
 * @property {() => Promise<void>} refresh           events were missed: read the documents anew
 * @property {() => Promise<void>} settled           when nothing is left to send
 * @property {() => void} retry                      try again now
 * @property {() => void} decide                     ask about a conflict that was put off
 */

/**
 * @param {object} parts
 * @param {Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'edit'|'annotation'>} parts.api
 * @param {Outbox} parts.outbox
 * @param {AbortSignal} parts.signal
 * @param {(text: string, options?: import('../views/toasts.js').ToastOptions) => void} parts.toast
 * @param {() => string} parts.author
 * @param {() => void} [parts.edited]   called with each edit, before it is shown
 * @param {(ms: number) => Promise<void>} [parts.pause]
 * @param {() => string} [parts.newId]
 * @returns {Editor}
 */
export function createEditor({ store, api, outbox, signal, toast, author, edited = () => {}, pause, newId = () => crypto.randomUUID() }) {
  /** @type {string|null} */
  let run = null;
  let ready = false;
  /** What the server has acknowledged. @type {Record<string, TrackDoc>} */
  let confirmed = {};
  /** @type {Pending[]} */
  let pending = [];
  /** Made before the documents have come: shown on what the engine said, checked and sent when they have. @type {Early[]} */
  let early = [];
  /** Refused because somebody else was first; kept in the outbox until a person decides. @type {Pending[]} */
  let held = [];
  /** What was done last, and by whom, to the tracks that edits are held for. @type {Record<string, import('./keeping.js').Last>} */
  let others = {};
  let sending = false;
  let wake = () => {};
  /** @type {(() => void)[]} */
  const waiters = [];
  /** One undo or redo after the other, however fast the key repeats. */
  let reverting = Promise.resolve();

  /** Pause between two tries; `retry` ends it. @param {number} ms */
  const wait = pause ?? ((ms) => new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    wake = () => {
      clearTimeout(timer);
      resolve(undefined);
    };
  }));

  /** Documents as they are with everything that is on its way. */
  function show() {
    const review = store.get().review;
    if (review === null || run === null) return;
    const docs = projected(review, confirmed, [...pending, ...early], new Date().toISOString());
    /** @param {boolean} waits @returns {(one: Pending|Early) => {op_id: string, command: Command, held: boolean}} */
    const entry = (waits) => ({ op_id, command }) => ({ op_id, command: /** @type {Command} */ (command), held: waits });
    const unsaved = [...held.map(entry(true)), ...pending.map(entry(false)), ...early.map(entry(false))];
    store.dispatch((state) => changeReview(state, { docs, unsaved }));
  }

  /** @param {readonly TrackDoc[]} docs */
  function confirm(docs) {
    for (const doc of docs) {
      if ((confirmed[doc.key]?.revision ?? -1) <= doc.revision) confirmed = { ...confirmed, [doc.key]: doc };
    }
  }

  /** @param {Pending} made */
  function keep(made) {
    outbox.put(made).catch(() => {
      store.dispatch((state) => showBanner(state, {
        id: 'outbox', tone: 'warning', text: 'This browser cannot keep unsaved work (a private window, or a page of an older version beside this one?). Wait for "All saved" before you close the page.',
      }));
    });
  }

  /** @param {Pending['command']} command */
  function enqueue(command) {
    const review = store.get().review;
    if (run === null || review === null) return;
    const made = { op_id: newId(), run, author: author(), command, seen: revisionsSeen(review, confirmed, command) };
    edited();
    pending = [...pending, made];
    show();
    keep(made);
    void send();
  }

  /** @param {Pending} done */
  function forget(done) {
    pending = pending.filter(({ op_id }) => op_id !== done.op_id);
    outbox.remove(done.op_id).catch(() => {});
  }

  async function send() {
    if (sending || !ready) return;
    sending = true;
    let tries = 0;
    while (pending.length && run !== null && !signal.aborted) {
      const next = pending[0];
      const here = run;
      try {
        const answer = await api.edit(here, { op_id: next.op_id, author: next.author, command: next.command }, next.seen, { signal });
        if (run !== here) {
          outbox.remove(next.op_id).catch(() => {});
          continue;
        }
        tries = 0;
        stored(next, answer);
      } catch (thrown) {
        if (signal.aborted) break;
        if (run !== here) continue;
        if (thrown instanceof ApiError && (!FINAL.has(thrown.status) || thrown.code === CHANGED)) {
          if (thrown.code !== 'offline') {
            store.dispatch((state) => showBanner(state, { id: 'saving', tone: 'warning', text: `${thrown.message} Your changes are kept in this page and sent again.` }));
          }
          await wait(PAUSES[Math.min(tries++, PAUSES.length - 1)]);
          continue;
        }
        await refused(next, thrown);
      }
    }
    sending = false;
    if (pending.length === 0) for (const resolve of waiters.splice(0)) resolve();
  }

  /** @param {Pending} next @param {import('../types.js').EditAnswer} answer */
  function stored(next, answer) {
    const behind = rebased(pending.filter(({ op_id }) => op_id !== next.op_id), answer.docs);
    pending = behind.pending;
    // first those that build on it: after a crash in between it is sent once more and answered as before
    Promise.all(behind.changed.map((one) => outbox.put(one))).then(() => outbox.remove(next.op_id)).catch(() => {});
    confirm(answer.docs);
    store.dispatch((state) => hideBanner(changeReview(state, { seq: answer.seq, undo: answer.undo, redo: answer.redo }), 'saving'));
    show();
    if (next.command.name === 'undo' || next.command.name === 'redo') announce(next.command.name, answer.docs);
  }

  /** @param {Pending} next @param {unknown} thrown */
  async function refused(next, thrown) {
    const own = next.command.name !== 'undo' && next.command.name !== 'redo';
    if (own && thrown instanceof ApiError && thrown.code === 'stale') {
      const current = /** @type {TrackDoc[]} */ (thrown.details.current ?? []);
      confirm(current);
      if (!leaveOut(next, current) && !putOnTop(next)) await hold(next, thrown.details.by ?? {});
    } else {
      forget(next);
      const why = thrown instanceof ApiError ? thrown.message : sentence(thrown);
      toast(`${describe(next.command.name)} was not possible. ${named(why, store.get().review?.docs ?? {})}`, { tone: 'bad' });
      if (!own) void refresh();
    }
    show();
  }

  /** Until a person decides, with those behind it. @param {Pending} next @param {typeof others} by   who was first */
  async function hold(next, by) {
    const { held: bound, left } = parted(pending, next);
    pending = left;
    held = [...held, ...bound];
    others = { ...others, ...by };
    await refresh(); // also those that it was merged into
    decide();
  }

  /** The same operation otherwise, to be sent in its place. @param {Pending} moved */
  function replace(moved) {
    pending = pending.map((one) => (one.op_id === moved.op_id ? moved : one));
    keep(moved);
  }

  /**
   * One verdict on many is not for tracks that look otherwise by now; the others get it.
   * @param {Pending} next
   * @param {readonly TrackDoc[]} current   those that somebody else has changed
   */
  function leaveOut(next, current) {
    const less = without(next, current.map(({ key }) => key));
    if (less === next) return false;
    if (less === null) forget(next);
    else replace(less);
    const names = listed(current.map(({ key }) => trackName(key, confirmed[key])), NAMED);
    toast(`No verdict on ${current.length === 1 ? 'track' : 'tracks'} ${names}: somebody else was first.`, { stays: true });
    return true;
  }

  /** A note takes nothing away from what others have said: it goes on top, unless more of ours waits behind it. @param {Pending} next */
  function putOnTop(next) {
    const review = store.get().review;
    const key = next.command.name === 'add_note' ? /** @type {Command} */ (next.command).key : null;
    if (review === null || key === null || confirmed[key]?.gone || pending.filter((one) => keysOf(one).includes(key)).length > 1) return false;
    replace({ ...next, seen: revisionsSeen(review, confirmed, next.command) });
    return true;
  }

  /** Nobody goes on working on a track that is gone: where the selected one is, what it became part of is selected. */
  function leaveGone() {
    const { selected, docs } = store.get().review ?? { selected: null, docs: {} };
    const doc = selected === null ? undefined : docs[selected];
    if (!doc?.gone) return null;
    store.dispatch((state) => select(state, doc.merged_into));
    return doc;
  }

  /** Show both versions of what is held, and let a person choose. */
  function decide() {
    const review = store.get().review;
    if (held.length === 0 || review === null) return;
    const plan = planned(review, confirmed, held, new Date().toISOString());
    /** @param {boolean} again */
    const settle = (again) => {
      const bound = held;
      held = [];
      others = {};
      store.dispatch((state) => hideBanner(state, 'conflict'));
      // what has come in the meantime counts too
      const { commands } = again ? planned(store.get().review ?? review, confirmed, bound, '') : { commands: [] };
      for (const command of commands) enqueue(command);
      // only now: a page that dies in between asks once more, and has lost nothing
      for (const one of bound) outbox.remove(one.op_id).catch(() => {});
      show();
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
    store.dispatch((state) => openDialog(showBanner(state, {
      id: 'conflict', tone: 'warning', text, action: { label: 'Decide', operation: 'decide-conflict' },
    }), { kind: 'conflict', data: { ...plan, others, keepMine: () => settle(true), takeTheirs: () => settle(false) } }));
  }

  /** What the undo or redo under way is about. @type {import('../types.js').UndoTarget|null} */
  let target = null;

  /** Undo must not change what nobody looks at. @param {'undo'|'redo'} what @param {readonly TrackDoc[]} docs */
  function announce(what, docs) {
    const about = target;
    if (about === null) return;
    const subject = subjectOf(docs, about.frame);
    store.dispatch((state) => select(about.frame === null ? state : seek(state, about.frame), subject?.key ?? null));
    const doc = subject ?? docs[0];
    toast(`${what === 'undo' ? 'Undone' : 'Done again'}: ${describeUndone(about.name, about.frame, doc && trackName(doc.key, doc), docs.length)}`, { topic: 'undo' });
  }

  /** @returns {Promise<void>} */
  const settled = () => (pending.length === 0 && !sending ? Promise.resolve() : new Promise((resolve) => waiters.push(() => resolve(undefined))));

  /** @param {'undo'|'redo'} what */
  function revert(what) {
    if (pending.length && store.get().connection === 'offline') toast(`The server cannot be reached: ${what} waits until everything is saved.`);
    reverting = reverting.then(async () => {
      await settled();
      target = store.get().review?.[what] ?? null;
      if (target === null || run === null) return;
      enqueue({ name: what, op_id: target.op_id });
      await settled();
    });
    return reverting;
  }

  async function refresh() {
    const here = run;
    if (here === null || !ready) return;
    const annotation = await api.annotation(here, author(), { signal }).catch(() => null);
    if (annotation === null || run !== here) return;
    confirm(annotation.docs);
    store.dispatch((state) => changeReview(state, { seq: annotation.seq, undo: annotation.undo, redo: annotation.redo }));
    show();
  }

  /** @param {string} wanted */
  async function read(wanted) {
    for (let tries = 0; ; tries += 1) {
      try {
        return await api.annotation(wanted, author(), { signal });
      } catch (thrown) {
        if (signal.aborted || run !== wanted) return null;
        if (!(thrown instanceof ApiError) || FINAL.has(thrown.status)) throw thrown;
        await wait(PAUSES[Math.min(tries, PAUSES.length - 1)]);
      }
    }
  }

  /** @param {Command} command @param {string|null} [of]   the run that it is meant for */
  function edit(command, of = run) {
    const review = store.get().review;
    if (of !== run) {
      toast(`${describe(command.name)} was not possible: it was meant for the run that was open before.`, { tone: 'bad' });
      return false;
    }
    if (review === null || run === null) return false;
    if (!ready) {
      edited();
      early = [...early, { op_id: newId(), author: author(), command }];
      show();
      return true;
    }
    try {
      applyCommand({ ...docsFor(review, command), ...review.docs }, command, { author: author(), time: '' });
    } catch (thrown) {
      if (!(thrown instanceof CommandError)) throw thrown;
      toast(named(thrown.message, review.docs), { tone: 'bad' });
      return false;
    }
    enqueue(command);
    return true;
  }

  return {
    async open(wanted) {
      run = wanted;
      ready = false;
      early = [];
      confirmed = {};
      pending = [];
      held = [];
      others = {};
      const [annotation, kept] = await Promise.all([read(wanted), outbox.load(wanted).catch(() => [])]);
      if (annotation === null || run !== wanted) return;
      confirmed = Object.fromEntries(annotation.docs.map((doc) => [doc.key, doc]));
      pending = kept;
      ready = true;
      const made = early;
      early = [];
      store.dispatch((state) => changeReview(state, { seq: annotation.seq, undo: annotation.undo, redo: annotation.redo }));
      show();
      if (kept.length) toast(`${kept.length} change${kept.length === 1 ? '' : 's'} of an earlier visit ${kept.length === 1 ? 'is' : 'are'} being saved.`);
      for (const { command } of made) edit(command);
      void send();
    },
    close() {
      run = null;
      ready = false;
      early = [];
      pending = [];
      held = [];
      // said again when the run is opened again
      store.dispatch((state) => hideBanner(hideBanner(state, 'conflict'), 'saving'));
      wake();
    },
    edit,
    undo: () => revert('undo'),
    redo: () => revert('redo'),
    hear(docs, op_id) {
      if (pending.some((mine) => mine.op_id === op_id)) return; // the answer to it is on its way
      const looked = store.get().review?.selected ?? null;
      const there = looked !== null && !store.get().review?.docs[looked]?.gone;
      confirm(docs);
      show();
      const doc = there ? leaveGone() : null;
      if (doc) toast(`Track ${trackName(doc.key, doc)} was ${doc.merged_into ? `merged into ${trackName(doc.merged_into)}` : 'deleted'} in another page.`, { stays: true });
    },
    refresh,
    settled,
    retry: () => wake(),
    decide,
  };
}
