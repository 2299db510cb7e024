// @ts-check
/**
 * Lets the server follow a sign, puts the proposals into the store as they arrive, and accepts or drops them. Proposals
 * that are not accepted are not stored: the server forgets them when they are dropped, or when no page asks for them
 * any more.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../model/following.js').Following} Following
 * @typedef {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>} NewFollow
 */
import { isRetryable, errorMessage } from '../api/errors.js';
import { sleep as pause } from '../api/sleep.js';
import { acceptCommand, isInProgress, newFollowing, requestWith } from '../model/following.js';
import { putFollowing, setFollowing } from '../store/actions/review.js';

/** How long the server may wait for new proposals before it answers, s. */
const POLL_WAIT_S = 5;
/** Interval of requests once all proposals have arrived, ms: another page may accept or drop them. */
const IDLE_POLL_INTERVAL_MS = 5000;
/** Delay before a failed request is repeated, ms. */
const RETRY_DELAY_MS = 1000;
/** Delay before a correction is followed, because more key presses may come, ms. */
const CORRECTION_DELAY_MS = 150;

/**
 * @typedef {object} FollowControl
 * @property {(wanted: NewFollow) => void} start        start a follow and drop earlier proposals
 * @property {(anchor: import('../types.js').FollowAnchor) => void} correct   add an anchor and follow again between its neighbours
 * @property {() => boolean} accept                 accept the proposals as one operation; false: there are none
 * @property {() => void} drop
 * @property {(run: string) => void} open           a run was opened: show the proposals that wait there for this person
 * @property {() => void} close                     the run was closed
 */

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'startFollow'|'findFollow'|'follow'|'dropFollow'>, edit: App['edit'],
 *   author: () => string|null, signal: AbortSignal, toast: import('../core/toast.js').Notify,
 *   sleep?: (ms: number, signal: AbortSignal) => Promise<void>}} setup
 * @returns {FollowControl}
 */
export function createFollowControl({ store, api, edit, author, signal, toast, sleep = pause }) {
  /** Aborts the requests about the present proposals. @type {AbortController} */
  let requests = new AbortController();

  const current = () => store.get().review?.following ?? null;

  /** Abort the present requests; returns the signal of the new ones. */
  function restartRequests() {
    requests.abort();
    requests = new AbortController();
    return AbortSignal.any([requests.signal, signal]);
  }

  /** @param {NewFollow} wanted @param {number} [delay] */
  async function start(wanted, delay = 0) {
    const run = store.get().review?.run?.id;
    if (run === undefined) return;
    const previous = current();
    const ended = restartRequests();
    const next = newFollowing(wanted);
    // cut-off frames stay cut off, and the old proposals stay visible until new ones arrive
    store.dispatch(
      setFollowing,
      previous?.key === wanted.key
        ? { ...next, from: previous.from, to: previous.to, proposals: { ...previous.proposals, ...next.proposals } }
        : next,
    );
    if (delay) await sleep(delay, ended);
    if (ended.aborted) return;
    try {
      const answer = await api.startFollow(run, { ...wanted, author: author() });
      if (ended.aborted) {
        if (current()?.id == null) void api.dropFollow(answer.id).catch(() => {});
        return;
      }
      store.dispatch((state) =>
        putFollowing(setFollowing(state, { ...next, from: current()?.from ?? null, to: current()?.to ?? null }), null, answer),
      );
      await poll(answer.id, ended);
    } catch (thrown) {
      fail(thrown, ended);
    }
  }

  /** Poll until a person has decided. @param {string} id @param {AbortSignal} ended */
  async function poll(id, ended) {
    for (;;) {
      const following = current();
      if (ended.aborted || following?.id !== id) return;
      const inProgress = isInProgress(following);
      if (!inProgress) await sleep(IDLE_POLL_INTERVAL_MS, ended);
      if (ended.aborted) return;
      try {
        const answer = await api.follow(id, following.next, inProgress ? POLL_WAIT_S : 0, { signal: ended });
        if (ended.aborted) return;
        store.dispatch(putFollowing, id, answer);
      } catch (thrown) {
        if (ended.aborted) return;
        if (!isRetryable(thrown)) return fail(thrown, ended);
        await sleep(RETRY_DELAY_MS, ended);
      }
    }
  }

  /** @param {unknown} thrown @param {AbortSignal} ended */
  function fail(thrown, ended) {
    if (ended.aborted) return;
    restartRequests();
    store.dispatch(setFollowing, null);
    toast(errorMessage(thrown), { tone: 'bad' });
  }

  function close() {
    const id = current()?.id;
    restartRequests();
    if (id) void api.dropFollow(id).catch(() => {});
  }

  function drop() {
    close();
    store.dispatch(setFollowing, null);
  }

  // its drawing may have been undone, or somebody else may have deleted it
  const unsubscribe = store.subscribe(({ review }) => {
    if (review?.following && review.docs[review.following.key]?.gone) drop();
  });
  signal.addEventListener('abort', unsubscribe, { once: true });

  return {
    start: (wanted) => void start(wanted),
    correct(anchor) {
      const following = current();
      if (following !== null) void start(requestWith(following, anchor), CORRECTION_DELAY_MS);
    },
    accept() {
      const { review } = store.get();
      const command = review?.following ? acceptCommand(review.following, review.frame) : null;
      if (command === null || !edit(command)) return false;
      drop();
      return true;
    },
    drop,
    async open(run) {
      const ended = restartRequests();
      try {
        const found = await api.findFollow(run, author(), { signal: ended });
        if (found === null || ended.aborted || store.get().review?.run?.id !== run || current() !== null) return;
        store.dispatch((state) => putFollowing(setFollowing(state, newFollowing(found)), null, found));
        await poll(found.id, ended);
      } catch {
        // if the proposals are needed after all, the user can follow again
      }
    },
    close,
  };
}
