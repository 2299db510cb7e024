// @ts-check
/**
 * One state, changed only by pure actions. Listeners are called once after all actions of one turn.
 *
 * @typedef {import('../state-types.js').State} State
 * @typedef {import('../state-types.js').Store} Store
 */

/**
 * @param {State} initial
 * @param {(run: () => void) => void} [defer]   defers the call of listeners; tests pass one that they control
 * @returns {Store}
 */
export function createStore(initial, defer = (run) => void Promise.resolve().then(run)) {
  let state = initial;
  let pending = false;
  /** @type {Set<(state: State) => void>} */
  const listeners = new Set();

  function notifyListeners() {
    pending = false;
    for (const listener of [...listeners]) listener(state);
  }

  return {
    get: () => state,
    dispatch(action, ...args) {
      const next = action(state, ...args);
      if (next === state) return;
      state = next;
      if (pending) return;
      pending = true;
      defer(notifyListeners);
    },
    subscribe(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
}
