// @ts-check
/**
 * Answers and events of the server, brought into one order.
 *
 * A list that the server made before something happened can arrive after the event that tells of it, and would hide
 * that event for good. So what is heard while an answer is on its way is heard once more on top of it. Each event says
 * all of its subject, so hearing one twice does no harm, and what is newer than both comes later by itself.
 */
import { dropMade, dropRun, dropVideo, putOutput, putModel, putRun, putVideo } from './actions/page.js';

import { dropAssignment, putAssignment } from './actions/team.js';

/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../types.js').ServerEvent} ServerEvent */

/**
 * @typedef {object} CatchUp
 * @property {(event: ServerEvent) => void} receive   takes one event into the store
 * @property {<T>(ask: () => Promise<T>, put: (state: State, answer: T) => State) => Promise<T>} load
 *   asks, and takes the answer into the store with what has been heard since it was asked
 */

/**
 * The state after an event; the same one if it says nothing of what the page keeps.
 * @param {State} state
 * @param {ServerEvent} event
 * @returns {State}
 */
export function afterEvent(state, event) {
  switch (event.kind) {
    case 'video':
      return putVideo(state, event.data);
    case 'run':
      return putRun(state, event.data);
    case 'artefact':
      return putOutput(state, event.data);
    case 'model':
      return putModel(state, event.data);
    case 'assignment':
      return putAssignment(state, event.data);
    case 'removed':
      if (event.data.kind === 'assignment') return dropAssignment(state, event.data.id);
      return dropMade(dropRun(dropVideo(state, event.subject), event.subject), event.subject);
    default:
      return state;
  }
}

/**
 * @param {import('../state-types.js').Store} store
 * @returns {CatchUp}
 */
export function createCatchUp(store) {
  /** What has been heard since each question that is not answered yet. @type {Set<ServerEvent[]>} */
  const open = new Set();
  return {
    receive(event) {
      for (const received of open) received.push(event);
      store.dispatch(afterEvent, event);
    },
    async load(ask, put) {
      /** @type {ServerEvent[]} */
      const received = [];
      open.add(received);
      try {
        const answer = await ask();
        store.dispatch((state) => received.reduce(afterEvent, put(state, answer)));
        return answer;
      } finally {
        open.delete(received);
      }
    },
  };
}
