// @ts-check
/** Routes of corrections: edits, follows, corrections adopted from an earlier run. */

import { encode } from './http.js';
import { RUN } from './runs.js';
import { expectObject } from './shapes.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Command} Command */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{kept: string[], not_needed: string[], conflicts: {key: string, reason: string, frame: number}[]}} Adoption */

const FOLLOW = /** @type {const} */ ({
  id: 'string',
  key: 'string',
  state: 'string',
  anchors: 'array',
  proposals: 'array',
  endings: 'array',
  next: 'number',
});

/** @param {import('./http.js').Routes} setup */
export function editRoutes({ json }) {
  return {
    /** @param {string} run @param {string|null} [author] @param {Call} [call] @returns {Promise<import('../types.js').Annotation>} */
    annotation: async (run, author, call) =>
      expectObject('GET /runs/…/annotation', await json(`/runs/${encode(run)}/annotation`, { ...call, query: { author } }), {
        seq: 'number',
        docs: 'array',
      }),
    /**
     * @param {string} run
     * @param {{op_id: string, author: string, command: Command|{name: 'undo'|'redo', op_id: string}}} edit
     * @param {Record<string, number>} revisions   of every track that the command touches
     * @param {Call} [call]
     * @returns {Promise<import('../types.js').EditAnswer>}
     */
    edit: async (run, edit, revisions, call) => {
      const match = Object.entries(revisions)
        .map(([key, revision]) => `"${key}:${revision}"`)
        .join(', ');
      const answer = await json(`/runs/${encode(run)}/edits`, {
        ...call,
        method: 'POST',
        body: edit,
        headers: match ? { 'If-Match': match } : {},
      });
      return expectObject('POST /runs/…/edits', answer, { op_id: 'string', seq: 'number', docs: 'array' });
    },
    /** @param {string} video @param {string|null} author @param {Call} [call] @returns {Promise<Run>} a run without an engine, for drawing all tracks by hand */
    startByHand: async (video, author, call) =>
      expectObject(
        'POST /videos/…/runs/by-hand',
        await json(`/videos/${encode(video)}/runs/by-hand`, { ...call, method: 'POST', body: { author } }),
        RUN,
      ),
    /** @param {string} run @param {{key: string, anchors: import('../types.js').FollowAnchor[], only: string|null, first: number, last: number|null, author: string|null}} wanted @param {Call} [call] @returns {Promise<import('../types.js').Follow>} */
    startFollow: async (run, wanted, call) =>
      expectObject('POST /runs/…/follows', await json(`/runs/${encode(run)}/follows`, { ...call, method: 'POST', body: wanted }), FOLLOW),
    /** @param {string} run @param {number} frame @param {Call} [call] @returns {Promise<void>} announces that a follow may start there */
    expectFollow: (run, frame, call) => json(`/runs/${encode(run)}/follows/expected`, { ...call, method: 'POST', body: { frame } }),
    /** @param {string} run @param {string|null} author @param {Call} [call] @returns {Promise<import('../types.js').Follow|null>} */
    findFollow: async (run, author, call) =>
      expectObject('GET /runs/…/follows', await json(`/runs/${encode(run)}/follows`, { ...call, query: { author } }), { found: 'nullable' })
        .found,
    /** @param {string} id @param {number} after @param {number} wait   seconds @param {Call} [call] @returns {Promise<import('../types.js').Follow>} */
    follow: async (id, after, wait, call) =>
      expectObject('GET /follows/…', await json(`/follows/${encode(id)}`, { ...call, query: { after, wait } }), FOLLOW),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    dropFollow: (id, call) => json(`/follows/${encode(id)}`, { ...call, method: 'DELETE' }),
    /** @param {string} run @param {number} after @param {Call} [call] @returns {Promise<{edits: import('../model/deleted.js').LogRow[]}>} at most 1,000 rows of the log after the number */
    edits: async (run, after, call) =>
      expectObject('GET /runs/…/edits', await json(`/runs/${encode(run)}/edits`, { ...call, query: { after } }), { edits: 'array' }),
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').Earlier|null>} */
    earlier: async (run, call) =>
      expectObject('GET /runs/…/earlier', await json(`/runs/${encode(run)}/earlier`, call), { found: 'nullable' }).found,
    /** @param {string} run @param {string} from @param {string|null} author @param {Call} [call] @returns {Promise<Adoption>} */
    adopt: async (run, from, author, call) =>
      expectObject(
        'POST /runs/…/adopt',
        await json(`/runs/${encode(run)}/adopt`, { ...call, method: 'POST', body: { from_run: from, author }, timeout: 120_000 }),
        { kept: 'array', not_needed: 'array', conflicts: 'array' },
      ),
  };
}
