// @ts-check

/**
 * Edit a track in the frame of the cursor.
 *
 * @param {import('../page-types.js').ViewApp} app
 * @param {string} key
 * @param {Partial<import('../types.js').Command> & Pick<import('../types.js').Command, 'name'>} fields
 * @param {string|null} [runId]   the run that the edit is for, if another one may be open by now
 * @returns {boolean} whether the edit was made
 */
export function editTrack(app, key, fields, runId) {
  const review = app.store.get().review;
  return review !== null && app.edit({ frame: review.frame, key, ...fields }, runId);
}
