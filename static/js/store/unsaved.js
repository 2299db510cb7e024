// @ts-check
/** How much is on its way to the server, of the open run and of others. Pure. */

/**
 * @param {Pick<import('../state-types.js').State, 'review'|'elsewhere'>} state
 * @returns {{unsaved: number, held: number}} operations without an acknowledgement; those of them that a person has to decide on
 */
export function unsavedOf({ review, elsewhere }) {
  const here = review?.unsaved ?? [];
  /** @param {{unsaved: number}[]} runs */
  const sum = (runs) => runs.reduce((total, { unsaved }) => total + unsaved, 0);
  return {
    unsaved: here.length + sum(elsewhere),
    held: here.filter(({ held }) => held).length + sum(elsewhere.filter(({ held }) => held)),
  };
}
