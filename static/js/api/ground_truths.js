// @ts-check
/** Routes of ground truths and of comparisons. */

import { encode } from './http.js';
import { expectList, expectObject } from './shapes.js';

/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{id: string, name: string, count: number}} GroundTruth */
/** @typedef {import('../types.js').GroundTruthBox} GroundTruthBox */
/** @typedef {import('./compare-types.js').Comparison} Comparison */

/** @param {import('./http.js').Routes} setup */
export function groundTruthRoutes({ json }) {
  return {
    /** @param {string} video @param {Call} [call] @returns {Promise<GroundTruth[]>} */
    groundTruths: async (video, call) => {
      const answer = expectObject('GET /videos/…/ground-truths', await json(`/videos/${encode(video)}/ground-truths`, call), {
        ground_truths: 'array',
      });
      return expectList('GET /videos/…/ground-truths', answer.ground_truths, { id: 'string', name: 'string', count: 'number' });
    },
    /** @param {string} truth @param {number} first @param {number} last @param {Call} [call] @returns {Promise<GroundTruthBox[]>} */
    truthBoxes: async (truth, first, last, call) => {
      const answer = await json(`/ground-truths/${encode(truth)}/boxes`, { ...call, query: { first, last } });
      return expectList('GET /ground-truths/…/boxes', Array.isArray(answer) ? answer : answer?.boxes, {
        frame: 'number',
        box: 'array',
        class_id: 'nullable',
      });
    },
    /** @param {string} truth @param {Call} [call] @returns {Promise<void>} */
    removeTruth: (truth, call) => json(`/ground-truths/${encode(truth)}`, { ...call, method: 'DELETE' }),
    /**
     * Correct a run by signs of a ground truth, all in one operation.
     * @param {string} run
     * @param {{truth: string, signs?: number[], label?: number, author?: string|null}} wanted
     * @param {Call} [call]
     * @returns {Promise<import('./compare-types.js').TakenOver>}
     */
    takeOver: async (run, wanted, call) =>
      expectObject(
        'POST /runs/…/take-over',
        await json(`/runs/${encode(run)}/take-over`, { ...call, method: 'POST', body: wanted, timeout: 120_000 }),
        { changed: 'number', made: 'number', same: 'number', op_id: 'nullable', skipped: 'array' },
      ),
    /** @param {string} reference   `run:ID`, `annotation:RUN` or `truth:ID` @param {string} candidate @param {Call} [call] @returns {Promise<Comparison>} */
    compare: async (reference, candidate, call) =>
      expectObject('GET /compare', await json('/compare', { timeout: 120_000, ...call, query: { reference, candidate } }), {
        figures: 'object',
        confusion: 'object',
      }),
  };
}
