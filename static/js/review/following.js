// @ts-check
/**
 * Has a sign followed by the server, brings the proposals into the store as they come, and takes or drops them. What is
 * not taken is nobody's data: the server forgets it when it is dropped, or when no page asks for it any more.
 *
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../model/following.js').Following} Following
 * @typedef {Pick<Following, 'key'|'anchors'|'only'|'first'|'last'>} Asked
 */
import { ApiError, sentence } from '../api/errors.js';
import { acceptCommand, isUnderWay, newFollowing, requestWith } from '../model/following.js';
import { putFollowing, setFollowing } from '../store/actions/review.js';

/** How long the server waits for something new before it answers, s. */
const WAIT = 5;
/** Between two signs of life of proposals that wait for a person, ms; the server lets go after 20 s. */
const ALIVE = 5000;
/** Until the server is asked again that could not be reached, ms. */
const AGAIN = 1000;
/** A correction that goes on, as by keys, is followed once it rests, ms. */
const REST = 150;

/**
 * @typedef {object} FollowControl
 * @property {(asked: Asked) => void} start         follow; what was proposed before is dropped
 * @property {(anchor: import('../types.js').FollowAnchor) => void} correct   one more anchor: follow anew between its neighbours
 * @property {() => boolean} accept                 take the proposals as one operation; false: there is nothing to take
 * @property {() => void} drop
 * @property {(run: string) => void} open           a run was opened: what waits there for this person is shown again
 * @property {() => void} close                     the run was left
 */

/**
 * @param {{store: App['store'], api: Pick<App['api'], 'startFollow'|'findFollow'|'follow'|'dropFollow'>, edit: App['edit'],
 *   author: () => string|null, signal: AbortSignal, toast: (text: string, options?: any) => void,
 *   sleep?: (ms: number, signal: AbortSignal) => Promise<void>}} setup
 * @returns {FollowControl}
 */
export function createFollowing({ store, api, edit, author, signal, toast, sleep = rest }) {
  /** The conversation about the present proposals. @type {AbortController} */
  let talk = new AbortController();

  const now = () => store.get().review?.following ?? null;

  /** End what goes on; the new conversation's signal. */
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
    // what was cut off stays cut off; the old proposals stay in sight until new ones come
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

  /** Ask until a person has decided. @param {string} id @param {AbortSignal} over */
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
        if (!(thrown instanceof ApiError && thrown.passing)) return fail(thrown, over);
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
        // whoever wants the proposals follows again
      }
    },
    close() {
      const id = now()?.id;
      begin();
      if (id) void api.dropFollow(id).catch(() => {});
    },
  };
}

/** @param {number} ms @param {AbortSignal} signal   ends the wait early @returns {Promise<void>} */
function rest(ms, signal) {
  return new Promise((resolve) => {
    const timer = setTimeout(() => resolve(), ms);
    signal.addEventListener(
      'abort',
      () => {
        clearTimeout(timer);
        resolve();
      },
      { once: true },
    );
  });
}
