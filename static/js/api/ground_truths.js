// @ts-check
/** Routes of ground truths and of comparisons. */

/** @typedef {import('./http.js').Call} Call */
/** @typedef {{id: string, name: string, count: number}} GroundTruth */

const TAKEN_OVER = /** @type {const} */ ({ changed: 'number', made: 'number', same: 'number', op_id: 'nullable', skipped: 'array' });

/** @param {import('./http.js').Routes} routes */
export const groundTruthRoutes = ({ json, list, object }) => ({
  /** @param {string} video @param {Call} [call] @returns {Promise<GroundTruth[]>} */
  groundTruths: (video, call) =>
    list('GET /videos/…/ground-truths', [video], { id: 'string', name: 'string', count: 'number' }, call, 'ground_truths'),
  /** @param {string} truth @param {number} first @param {number} last @param {Call} [call] @returns {Promise<import('../types.js').GroundTruthBox[]>} */
  truthBoxes: (truth, first, last, call) =>
    list(
      'GET /ground-truths/…/boxes',
      [truth],
      { frame: 'number', box: 'array', class_id: 'nullable' },
      { ...call, query: { first, last } },
      'boxes',
    ),
  /** @param {string} truth @param {Call} [call] @returns {Promise<void>} */
  removeTruth: (truth, call) => json('DELETE /ground-truths/…', [truth], call),
  /**
   * Correct a run by signs of a ground truth, all in one operation.
   * @param {string} run
   * @param {{truth: string, signs?: number[], label?: number, author?: string|null}} wanted
   * @param {Call} [call]
   * @returns {Promise<import('./compare-types.js').TakenOver>}
   */
  takeOver: (run, wanted, call) => object('POST /runs/…/take-over', [run], TAKEN_OVER, { ...call, body: wanted, timeout: 120_000 }),
  /** @param {string} reference   `run:ID`, `annotation:RUN` or `truth:ID` @param {string} candidate @param {Call} [call] @returns {Promise<import('./compare-types.js').Comparison>} */
  compare: (reference, candidate, call) =>
    object('GET /compare', [], { figures: 'object', confusion: 'object' }, { timeout: 120_000, ...call, query: { reference, candidate } }),
});
