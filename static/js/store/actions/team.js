// @ts-check
/**
 * Actions on assignments. Pure.
 *
 * @typedef {import('../../state-types.js').State} State
 * @typedef {import('../../types.js').Assignment} Assignment
 */

/** @param {State} state @param {Assignment[]} assignments @returns {State} */
export const setAssignments = (state, assignments) => ({ ...state, assignments });

/**
 * Add or replace an assignment. An older version than the page has is ignored.
 * @param {State} state
 * @param {Assignment} next
 * @returns {State}
 */
export function putAssignment(state, next) {
  const known = state.assignments.find(({ id }) => id === next.id);
  if (known && known.revision > next.revision) return state;
  const assignments = known ? state.assignments.map((one) => (one === known ? next : one)) : [...state.assignments, next];
  return { ...state, assignments };
}

/** @param {State} state @param {number} id @returns {State} */
export const dropAssignment = (state, id) => ({ ...state, assignments: state.assignments.filter((one) => one.id !== id) });
