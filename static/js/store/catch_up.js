// @ts-check
/**
 * Brings answers and events of the server into one order.
 *
 * An answer that the server made before an event can arrive after it, and would overwrite the newer data for good.
 * Events that arrive while a request is pending are therefore applied again on top of its answer. An event contains its
 * whole subject, so applying it twice does no harm, and newer data arrives with a later event.
 */
import { dropOutputOrModel, dropRun, dropVideo, putOutput, putModel, putRun, putVideo } from './actions/page.js';

import { dropAssignment, putAssignment } from './actions/team.js';

/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../types.js').ServerEvent} ServerEvent */

/**
 * @typedef {object} CatchUp
 * @property {(event: ServerEvent) => void} receive   takes one event into the store
 * @property {<T>(ask: () => Promise<T>, put: (state: State, answer: T) => State) => Promise<T>} load
 *   makes a request, and puts the answer into the store with the events since the request applied on top
 */

/**
 * The state after an event; the same object if the event does not concern the page's data.
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
      return dropOutputOrModel(dropRun(dropVideo(state, event.subject), event.subject), event.subject);
    default:
      return state;
  }
}

/** @param {import('../state-types.js').Store} store @returns {CatchUp} */
export function createCatchUp(store) {
  /** For each pending request, the events since it was made. @type {Set<ServerEvent[]>} */
  const pendingRequests = new Set();
  return {
    receive(event) {
      for (const received of pendingRequests) received.push(event);
      store.dispatch(afterEvent, event);
    },
    async load(request, put) {
      /** @type {ServerEvent[]} */
      const received = [];
      pendingRequests.add(received);
      try {
        const answer = await request();
        store.dispatch((state) => received.reduce(afterEvent, put(state, answer)));
        return answer;
      } finally {
        pendingRequests.delete(received);
      }
    },
  };
}
