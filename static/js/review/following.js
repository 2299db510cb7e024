// @ts-check
/**
 * Lets the server follow a sign, puts the proposals into the store as they arrive, and accepts or drops them. Proposals
 * that are not accepted are not stored: the server forgets them when they are dropped, or when no page asks for them
 * any more.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../model/following.js').Following} Following
 * @typedef {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>} Asked
 */
import { mayRepeat, sentence } from '../api/errors.js';
import { sleep as pause } from '../api/sleep.js';
import { acceptCommand, isUnderWay, newFollowing, requestWith } from '../model/following.js';
import { putFollowing, setFollowing } from '../store/actions/review.js';

/** The server's longest wait for news before it answers, s. */
const WAIT = 5;
/** Interval of requests about waiting proposals, ms: another page may have accepted or dropped them. */
const ALIVE = 5000;
/** Pause before another request after the server could not be reached, ms. */
const AGAIN = 1000;
/** Pause after a correction before it is followed, because more key presses may come, ms. */
const REST = 150;

/**
 * @typedef {object} FollowControl
 * @property {(asked: Asked) => void} start         start a follow and drop earlier proposals
 * @property {(anchor: import('../types.js').FollowAnchor) => void} correct   add an anchor and follow again between its neighbours
 * @property {() => boolean} accept                 accept the proposals as one operation; false: there are none
 * @property {() => void} drop
 * @property {(run: string) => void} open           a run was opened: show the proposals that wait there for this person
 * @property {() => void} close                     the run was closed
 */

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'startFollow'|'findFollow'|'follow'|'dropFollow'>, edit: App['edit'],
 *   author: () => string|null, signal: AbortSignal, toast: (text: string, options?: any) => void,
 *   sleep?: (ms: number, signal: AbortSignal) => Promise<void>}} setup
 * @returns {FollowControl}
 */
export function createFollowing({ store, api, edit, author, signal, toast, sleep = pause }) {
  /** Aborts the requests about the present proposals. @type {AbortController} */
  let talk = new AbortController();

  const now = () => store.get().review?.following ?? null;

  /** Abort the present requests; returns the signal of the new ones. */
  function begin() {
    talk.abort();
    talk = new AbortController();
    return AbortSignal.any([talk.signal, signal]);
  }

  /** @param {Asked} asked @param {number} [delay] */
  async function start(asked, delay = 0) {
    const run = store.get().review?.run?.id;
    if (run === undefined) return;
    const before = now();
    const over = begin();
    const fresh = newFollowing(asked);
    // cut-off frames stay cut off, and the old proposals stay visible until new ones arrive
    store.dispatch(
      setFollowing,
      before?.key === asked.key
        ? { ...fresh, from: before.from, to: before.to, proposals: { ...before.proposals, ...fresh.proposals } }
        : fresh,
    );
    if (delay) await sleep(delay, over);
    if (over.aborted) return;
    try {
      const answer = await api.startFollow(run, { ...asked, author: author() });
      if (over.aborted) {
        if (now()?.id == null) void api.dropFollow(answer.id).catch(() => {});
        return;
      }
      store.dispatch((state) =>
        putFollowing(setFollowing(state, { ...fresh, from: now()?.from ?? null, to: now()?.to ?? null }), null, answer),
      );
      await listen(answer.id, over);
    } catch (thrown) {
      fail(thrown, over);
    }
  }

  /** Poll until a person has decided. @param {string} id @param {AbortSignal} over */
  async function listen(id, over) {
    for (;;) {
      const following = now();
      if (over.aborted || following?.id !== id) return;
      const waiting = isUnderWay(following);
      if (!waiting) await sleep(ALIVE, over);
      if (over.aborted) return;
      try {
        const answer = await api.follow(id, following.next, waiting ? WAIT : 0, { signal: over });
        if (over.aborted) return;
        store.dispatch(putFollowing, id, answer);
      } catch (thrown) {
        if (over.aborted) return;
        if (!mayRepeat(thrown)) return fail(thrown, over);
        await sleep(AGAIN, over);
      }
    }
  }

  /** @param {unknown} thrown @param {AbortSignal} over */
  function fail(thrown, over) {
    if (over.aborted) return;
    begin();
    store.dispatch(setFollowing, null);
    toast(sentence(thrown), { tone: 'bad' });
  }

  function forget() {
    const id = now()?.id;
    begin();
    store.dispatch(setFollowing, null);
    if (id) void api.dropFollow(id).catch(() => {});
  }

  return {
    start: (asked) => void start(asked),
    correct(anchor) {
      const following = now();
      if (following !== null) void start(requestWith(following, anchor), REST);
    },
    accept() {
      const { review } = store.get();
      const command = review?.following ? acceptCommand(review.following, review.frame) : null;
      if (command === null || !edit(command)) return false;
      forget();
      return true;
    },
    drop: forget,
    async open(run) {
      const over = begin();
      try {
        const found = await api.findFollow(run, author(), { signal: over });
        if (found === null || over.aborted || store.get().review?.run?.id !== run || now() !== null) return;
        store.dispatch((state) => putFollowing(setFollowing(state, newFollowing(found)), null, found));
        await listen(found.id, over);
      } catch {
        // if the proposals are needed after all, the user can follow again
      }
    },
    close() {
      const id = now()?.id;
      begin();
      if (id) void api.dropFollow(id).catch(() => {});
    },
  };
}
