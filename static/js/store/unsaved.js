// @ts-check
/** Numbers of unsaved operations of the open run and of others. Pure. */

/**
 * @param {Pick<import('../state-types.js').State, 'review'|'elsewhere'>} state
 * @returns {{unsaved: number, held: number}} unsaved: not acknowledged by the server; held: those of them that need a decision
 */
export function unsavedOf({ review, elsewhere }) {
  const operations = review?.unsaved ?? [];
  /** @param {{unsaved: number}[]} runs */
  const sum = (runs) => runs.reduce((total, { unsaved }) => total + unsaved, 0);
  return {
    unsaved: operations.length + sum(elsewhere),
    held: operations.filter(({ held }) => held).length + sum(elsewhere.filter(({ held }) => held)),
  };
}
